#pragma once
// A folder of camera raw files in place of a camera.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/camera_raw.h"
#include "hardware/rig_file/driver_catalogue.h"
#include "hardware/still_camera.h"

namespace wheatstone {

/// Hands the files over in the order of their names, each to the call that asks for its exposure
/// time; after the last one expose() throws kNotReady. Frames are as old as the folder: only what
/// was recorded is seen, whatever the rig does. A file is read when the one before has been handed
/// over.
class ReplayCamera final : public StillCamera {
 public:
  /// Throws kNotFound for a folder that is missing or has no files.
  explicit ReplayCamera(const std::filesystem::path& folder);

  /// Of the first file.
  DeviceIdentity identity() const override { return identity_; }
  /// The next file's time; kOutOfRange if another one is asked for.
  Duration offered_exposure(Duration) const override;
  Duration frame_duration(Duration exposure) const override { return exposure; }
  /// The largest of the files, whatever their pictures' size.
  std::uintmax_t largest_file(std::uintmax_t) const override { return largest_file_; }
  /// kFault for a file that cannot be read or does not say its exposure time, again and again.
  RawFrame expose(Duration, Deadline) override;
  void abort() noexcept override {}  // nothing takes long

 private:
  void read_next();
  const CameraRaw& next() const;

  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
  std::size_t done_ = 0;
  std::uintmax_t largest_file_ = 0;
  DeviceIdentity identity_;
  std::vector<std::byte> bytes_;
  std::optional<CameraRaw> next_;
  std::string trouble_;  // why there is no next one
  bool lost_ = false;
};

/// Driver "replay" of the rig file.
void add_replay_driver(DriverCatalogue&);

}  // namespace wheatstone
