#include "hardware/still/replay_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files.h"
#include "hardware/device_error.h"
#include "hardware/still/file_type.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using Kind = DeviceError::Kind;

constexpr double kSixthStop = 1.0 / 6;

}  // namespace

ReplayCamera::ReplayCamera(const fs::path& folder) : folder_(folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file()) files_.push_back(entry.path());
  if (error || files_.empty())
    throw DeviceError(Kind::kNotFound, "there are no pictures in " + folder.string(),
                      "name a folder of camera raw files");
  std::sort(files_.begin(), files_.end());
  for (const fs::path& file : files_)
    if (const std::uintmax_t bytes = fs::file_size(file, error); !error)
      largest_file_ = std::max(largest_file_, bytes);
  read_next();
  identity_ = {"replay", next_ ? next_->camera : "", next_ ? next_->serial : "", "",
               folder.string()};
}

void ReplayCamera::read_next() {
  next_.reset();
  if (done_ == files_.size()) return;
  try {
    bytes_ = read_bytes(files_[done_]);
    next_ = decode_camera_raw(bytes_, files_[done_]);
    if (next_->exposure_s > 0) return;
    next_.reset();
    trouble_ = files_[done_].string() + " does not say its exposure time";
  } catch (const FileError& e) {
    trouble_ = e.what();
  }
}

const CameraRaw& ReplayCamera::next() const {
  if (done_ == files_.size())
    throw DeviceError(Kind::kNotReady, "all pictures of " + folder_.string() + " are handed over",
                      "start again, or record more of them");
  if (!next_)
    throw DeviceError(Kind::kFault, "the next picture cannot be used: " + trouble_,
                      "take it out of the folder");
  return *next_;
}

Duration ReplayCamera::offered_exposure(Duration wanted) const {
  const double seconds = next().exposure_s;
  if (!(wanted.value() > 0 && std::abs(std::log2(seconds / wanted.value())) <= kSixthStop))
    throw DeviceError(
        Kind::kOutOfRange,
        fmt::format("the next picture was exposed for {} s, not for {} s", seconds, wanted.value()),
        "ask for the exposures in the order of the recording");
  return Duration::of(seconds);
}

RawFrame ReplayCamera::expose(Duration wanted, Deadline deadline) {
  const SteadyClock clock;
  lost_ = lost_ || !fs::exists(folder_);
  if (lost_)
    throw DeviceError(Kind::kDisconnected, "the folder " + folder_.string() + " is gone",
                      "bring it back, then run the command again");
  const Duration exposure = offered_exposure(wanted);
  if (deadline.cancel.stop_requested()) throw Cancelled("the replay was asked to stop");
  if (clock.now_ns() > deadline.at_ns)
    throw DeviceError(Kind::kTimeout, "the time for a picture was over before it was asked for",
                      "allow its exposure");
  RawFrame frame;
  frame.mosaic = next_->mosaic;
  frame.exposure = exposure;
  if (next_->iso > 0) frame.gain = next_->iso / 100;
  frame.camera_serial = next_->serial;
  frame.triggered_ns = clock.now_ns();
  frame.file = std::move(bytes_);
  frame.file_type = file_type_of(files_[done_]);
  ++done_;
  read_next();
  return frame;
}

void add_replay_driver(DriverCatalogue& catalogue) {
  catalogue.add<StillCamera>("replay", [](const TomlTable& table) -> DevicePlan<StillCamera> {
    const std::string folder = table.text("folder");
    return {"", folder, "", [folder](RigContext&) -> std::unique_ptr<StillCamera> {
              return std::make_unique<ReplayCamera>(folder);
            }};
  });
}

}  // namespace wheatstone
