#pragma once
// Marker lights behind a USB relay board.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/hid/hid_lights.h"

namespace wheatstone {

struct RelayBoardSettings {
  std::string board;                       // its own name, five characters
  Duration settle = Duration::of(0.05);    // 0..1 s; mechanical relays close and bounce for 20 ms
  std::shared_ptr<Transcript> transcript;  // null: none
};

/// A relay board that is plugged in.
struct RelayBoardFound {
  std::filesystem::path node;
  std::string board;  // empty: it could not be asked
  int channels = 0;
  std::optional<DeviceError> trouble;  // why it cannot be used
};
/// In the order of their nodes.
std::vector<RelayBoardFound> list_relay_boards();

/// Light i hangs on channel i + 1.
class RelayBoard final : public HidLights {
 public:
  /// Throws ArgumentError for settings that cannot be; kNotFound, also if several boards have this
  /// name; kBusy, kPermission, kFault. All channels are off then.
  RelayBoard(const RelayBoardSettings&, const Deadline&);

 private:
  RelayBoard(const RelayBoardSettings&, const RelayBoardFound&, const Deadline&);
  void write(Mask wanted, const Deadline&) override;
  Mask read(const Deadline&) override;

  std::string board_;
};

}  // namespace wheatstone
