#pragma once
// A still camera over libgphoto2 (docs/hardware/gphoto2.md, reference still_camera.md).

#include <memory>
#include <string>
#include <vector>

#include "hardware/still/call_thread.h"
#include "hardware/still_camera.h"

namespace wheatstone {

struct GphotoCameraSettings {
  std::string model;   // or part of it, as libgphoto2 names it; empty: any that can capture
  std::string serial;  // as the body says; empty: the only one
  // After a picture that did not come in time, before the next one: run by sh, given so long.
  std::string power_cycle;
  Duration power_cycle_limit = Duration::of(20);
  Duration delivery = Duration::of(4);      // from the end of an exposure till the file is here
  Duration settle = Duration::of(1);        // till a setting is read back as it was set
  Duration usb_patience = Duration::of(5);  // with one transfer
};

/// A camera that is plugged in.
struct StillCameraFound {
  std::string model, address;
  std::string serial;   // where it could be opened
  std::string trouble;  // why it cannot be used; empty: it can
};
std::vector<StillCameraFound> list_still_cameras();

/// Sets ISO 100 and raw files, and for each frame the exposure time, which is read back; the file
/// is fetched, checked and deleted from the card. The frame's exposure, ISO and serial are the
/// file's where it says them. After kTimeout, kProtocol and abort() the next call opens the body
/// anew; a picture that comes late then is not taken for the next one.
class GphotoCamera final : public StillCamera {
 public:
  /// Throws kNotFound, also if several fit; kRefused in the wrong USB mode, without manual
  /// exposure times, ISO 100 or raw files; kBusy, kPermission, kTimeout, kProtocol.
  GphotoCamera(const GphotoCameraSettings&, const Deadline&);
  ~GphotoCamera() override;

  DeviceIdentity identity() const override { return identity_; }
  Duration offered_exposure(Duration) const override;
  Duration frame_duration(Duration exposure) const override;
  /// Nothing tells before the picture is there: as if no body compressed its raw files.
  std::uintmax_t largest_file(std::uintmax_t photosites) const override;
  RawFrame expose(Duration, Deadline) override;
  void abort() noexcept override { thread_.interrupt(); }

 private:
  struct Exposure {
    std::string text;  // as the body writes it
    double seconds = 0;
  };
  struct Connection;  // what the thread works on

  const Exposure& nearest(Duration) const;
  void connect(const Deadline&);
  void cycle_power(const Deadline&);

  GphotoCameraSettings settings_;
  CallThread thread_;
  std::shared_ptr<Connection> connection_;
  DeviceIdentity identity_;
  std::vector<Exposure> exposures_;  // shortest first
  bool lost_ = false, timed_out_ = false;
};

}  // namespace wheatstone
