#pragma once
// A Sony body in PC Remote mode without the wire: what it answers on its bulk and interrupt
// endpoints (reference still_camera.md, "PTP underneath").

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "sim/camera.h"
#include "sim/wire/still/ptp_container.h"
#include "sim/wire/still/ptp_properties.h"

namespace wheatstone {

namespace ptp {
enum Operation : std::uint16_t {
  kGetDeviceInfo = 0x1001,
  kOpenSession = 0x1002,
  kCloseSession = 0x1003,
  kGetStorageIds = 0x1004,
  kGetStorageInfo = 0x1005,
  kGetObjectHandles = 0x1007,
  kGetObjectInfo = 0x1008,
  kGetObject = 0x1009,
  kDeleteObject = 0x100b,
  kConnect = 0x9201,
  kExtendedInfo = 0x9202,
  kSetValue = 0x9205,
  kControl = 0x9207,
  kAllProperties = 0x9209
};
enum Response : std::uint16_t {
  kOk = 0x2001,
  kGeneralError = 0x2002,
  kSessionNotOpen = 0x2003,
  kUnsupported = 0x2005,
  kBadStorage = 0x2008,
  kBadHandle = 0x2009,
  kBadProperty = 0x200a,
  kStoreFull = 0x200c,
  kBusy = 0x2019,
  kBadValue = 0x201c,
  kBadParameter = 0x201d,
  kSessionOpen = 0x201e
};
inline constexpr std::uint16_t kObjectAdded = 0xc201, kPropertyChanged = 0xc203;
inline constexpr std::uint32_t kShot =
    0xffffc001;  // the handle of a picture on its way to the host
}  // namespace ptp

struct PtpCameraOptions {
  std::string manufacturer = "Sony Corporation", model = "ILCE-7RM3", version = "3.01";
  std::string serial;  // empty: the twin's
  bool settable_shutter = true;
  bool noise = true;
  double time_scale = 1;            // its exposures pass so many times as fast
  std::size_t memory_pictures = 8;  // more are refused until some are fetched
};

struct PtpReply {
  std::uint16_t code = ptp::kOk;
  std::vector<std::uint32_t> parameters;
  std::optional<std::vector<std::byte>> data;
};

/// Takes its pictures with SimulatedCamera of the World; each is a DNG file. Time is handed in and
/// never goes back. Not for two threads at once; holds the World's mutex while it exposes.
class PtpCameraFirmware {
 public:
  static constexpr std::size_t kPacketBytes = 512;
  static constexpr Nanoseconds kNever = std::numeric_limits<Nanoseconds>::max();

  explicit PtpCameraFirmware(World&, PtpCameraOptions = {});

  /// One transfer of the host's on the bulk-out endpoint. What is no PTP halts both bulk
  /// endpoints.
  void receive(std::span<const std::byte>, Nanoseconds now);
  /// What one request for `most` bytes on the bulk-in endpoint gets, which is less or nothing at
  /// the end of a container; none: it has nothing to say.
  std::optional<std::vector<std::byte>> bulk_in(std::size_t most, Nanoseconds now);
  /// The same of the interrupt endpoint.
  std::optional<std::vector<std::byte>> interrupt_in(Nanoseconds now);
  /// When a picture is done that the host does not know of.
  Nanoseconds next_event() const;
  bool halted() const { return halted_; }
  void clear_halt() { halted_ = false; }
  /// The class's device reset request: session closed, nothing under way.
  void reset();

  const PtpCameraOptions& options() const { return options_; }
  bool session_open() const { return session_ != 0; }
  bool exposing(Nanoseconds now) const { return !shots_.empty() && shots_.back().ready_ns > now; }
  std::size_t pictures_waiting() const { return shots_.size(); }
  std::map<std::uint16_t, PtpProperty>& properties() { return properties_; }
  std::uint32_t shutter_code() const { return properties_.at(ptp::kShutter).current; }

  // Faults. The functions may be empty.
  bool silent = false;                                        // answers nothing more
  bool full = false;                                          // no room for a picture
  bool takes_nothing = false;                                 // the button is pressed in vain
  std::function<std::uint32_t(std::uint32_t)> round_shutter;  // sets another time than asked
  /// Changes the answer to an operation.
  std::function<void(std::uint16_t operation, PtpReply&)> spoil;
  /// Changes the bytes of a container on their way out.
  std::function<void(std::vector<std::byte>&)> spoil_bytes;
  /// Changes the picture file.
  std::function<void(std::vector<std::byte>&)> spoil_file;
  std::size_t cut_after = SIZE_MAX;  // so many bytes more on bulk-in, then nothing
  /// A picture that nobody asked for, taken now.
  void take_picture(Nanoseconds now);

 private:
  struct Shot {
    std::vector<std::byte> file;
    int width_px = 0, height_px = 0;
    Nanoseconds ready_ns = 0;
    bool announced = false;
  };
  struct Transfer {
    std::vector<std::byte> bytes;
    std::size_t sent = 0;
  };

  PtpReply execute(const PtpContainer& command, std::span<const std::byte> data, Nanoseconds now);
  PtpReply device_info() const;
  PtpReply extended_info() const;
  PtpReply object_info(Nanoseconds now) const;
  PtpReply set(std::uint32_t property, std::span<const std::byte> data, bool button,
               Nanoseconds now);
  PtpReply press(Nanoseconds now);
  void answer(const PtpContainer& command, PtpReply, Nanoseconds now);
  void event(std::uint16_t code, std::uint32_t parameter);
  void advance(Nanoseconds now);

  World& world_;
  PtpCameraOptions options_;
  SimulatedCamera camera_;
  std::map<std::uint16_t, PtpProperty> properties_;
  PtpAssembler assembler_;
  std::optional<PtpContainer> command_;  // waits for its data
  std::uint32_t session_ = 0;
  std::deque<Transfer> out_;
  std::deque<std::vector<std::byte>> events_;
  std::deque<Shot> shots_;
  int taken_ = 0;
  bool halted_ = false;
};

}  // namespace wheatstone
