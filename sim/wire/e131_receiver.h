#pragma once
// An emulated streaming-ACN controller: datagrams in, LEDs out.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "hardware/transport/udp_receiver.h"
#include "sim/wire/led_ceiling.h"

namespace wheatstone {

/// What one datagram of E1.31 says; nothing where it is none.
struct E131Message {
  enum class Kind { kData, kSync } kind = Kind::kData;
  std::array<std::uint8_t, 16> source{};
  std::uint8_t sequence = 0, priority = 0;
  std::uint16_t universe = 0, sync_universe = 0;
  bool terminated = false;
  std::vector<std::uint8_t> slots;
};
std::optional<E131Message> parse_e131(std::span<const std::uint8_t>);

/// The controller without the wire. Universes carry 170 LEDs each, from `first_universe` on; it is
/// dark when a stream ends or has been silent for 2.5 s.
class E131Node {
 public:
  static constexpr Nanoseconds kLossNs = 2'500'000'000;

  E131Node(LedCeiling& ceiling, int first_universe, int universes)
      : ceiling_(ceiling),
        first_(first_universe),
        universes_(static_cast<std::size_t>(universes)) {}

  void receive(std::span<const std::uint8_t>, Nanoseconds now);
  /// Gives up streams that have been silent for too long.
  void run(Nanoseconds now);

  int refused() const { return refused_; }  // that were no E1.31
  int behind() const { return behind_; }    // with old sequence numbers
  int shown() const { return shown_; }      // changes of what shows
  int streams() const;                      // that are alive
  int terminations() const { return terminations_; }

 private:
  struct Universe {
    bool alive = false;
    std::array<std::uint8_t, 16> source{};
    std::uint8_t sequence = 0;
    Nanoseconds last_ns = 0;
    std::uint16_t sync_universe = 0;
    std::vector<std::uint8_t> waiting, slots;
  };
  void show();

  LedCeiling& ceiling_;
  const int first_;
  std::vector<Universe> universes_;
  int refused_ = 0, behind_ = 0, shown_ = 0, terminations_ = 0;
};

/// A node that listens on this machine. Everything here may be called from any thread.
class E131Receiver {
 public:
  E131Receiver(LedCeiling&, int first_universe, int universes);
  ~E131Receiver();
  E131Receiver(const E131Receiver&) = delete;
  E131Receiver& operator=(const E131Receiver&) = delete;

  int port() const { return port_; }
  /// Looks at or changes the node between two datagrams.
  void with_node(const std::function<void(E131Node&)>&);

  // Faults.
  void switch_off();
  /// Sees every datagram before the node does; drops it where it answers false.
  void filter(std::function<bool(std::span<const std::uint8_t>)>);

 private:
  void listen(const std::stop_token&);

  std::mutex mutex_;  // of the node and the filter
  E131Node node_;
  std::function<bool(std::span<const std::uint8_t>)> filter_;
  std::unique_ptr<UdpReceiver> socket_;
  int port_ = 0;
  std::jthread thread_;
};

}  // namespace wheatstone
