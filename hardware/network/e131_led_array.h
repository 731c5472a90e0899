#pragma once
// LED arrays behind a streaming-ACN controller (docs/hardware/e131.md).

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/units.h"
#include "hardware/led_array.h"
#include "hardware/led_mapping.h"
#include "hardware/network/e131_packet.h"
#include "hardware/transport/udp_sender.h"

namespace wheatstone {

struct E131Settings {
  std::string address;  // IPv4, of the controller; empty: multicast
  std::string from;     // address of this machine to send from; empty: as the routes say
  int port = kE131Port;
  int first_universe = 1;
  int sync_universe = 0;  // 0: the one after the last, or none if one universe is enough
  int priority = 100;
  LedMapping mapping;
  int leds_per_universe = 170;
  std::array<double, 3> response_gamma = {1, 1, 1};  // light = (code / 255)^gamma, of R, G, B
  double max_mean_drive = 1;
  Duration keep_alive = Duration::of(1);  // receivers give a stream up after 2.5 s
};

struct E131Universes {
  int count = 0;  // from the first on, with LEDs
  int sync = 0;   // 0: none
};
/// Throws ArgumentError for settings whose universes are not all there are.
E131Universes e131_universes(const E131Settings&);

/// Nothing comes back over E1.31: a frame "shows" when it has been sent. That nobody listens is
/// noticed where the controller's system says so, at the frame after. A thread repeats the last
/// frame as long as the object lives.
class E131LedArray final : public LedArray {
 public:
  /// Dark when it returns. Throws ArgumentError for settings that do not fit; kNotFound if no route
  /// leads there or nobody listens; kPermission; kFault.
  explicit E131LedArray(const E131Settings&);
  /// Dark, and the stream ends.
  ~E131LedArray() override;

  DeviceIdentity identity() const override;
  int rows() const override { return settings_.mapping.rows; }
  int columns() const override { return settings_.mapping.columns; }
  /// Throws kDisconnected if nobody listens any more or the network is gone; kRefused if all_off()
  /// came meanwhile: it is dark then.
  void set_frame(const LedFrame&, Deadline) override;
  double max_mean_drive() const override { return settings_.max_mean_drive; }
  void all_off() noexcept override;

 private:
  using Frame = std::vector<std::vector<std::uint8_t>>;  // a datagram for each universe

  Frame datagrams(const LedFrame&) const;
  int send(Frame&) noexcept;  // 0 or errno
  int send_one(std::size_t channel, std::vector<std::uint8_t>& datagram,
               std::size_t sequence_at) noexcept;
  void repeat(const std::stop_token&);
  void terminate() noexcept;
  [[noreturn]] void fail_lost();

  const E131Settings settings_;
  const std::vector<int> place_of_led_;
  const E131Universes universes_;
  const E131Source source_;

  std::mutex mutex_;  // of all below
  std::condition_variable_any never_;
  std::vector<UdpSender> channels_;  // of the universes, then of the synchronisation
  std::vector<std::uint8_t> sequences_;
  Frame black_, lit_;
  std::vector<std::uint8_t> sync_;
  bool dark_ = true;
  std::uint32_t switched_off_ = 0;  // how often
  int lost_ = 0;                    // the errno that says so

  std::jthread repeater_;
};

}  // namespace wheatstone
