#include "sim/observer.h"

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "hardware/device_error.h"

namespace wheatstone {
namespace {

constexpr std::uint64_t kObserverSeed = 0x6f62736572766572ULL;  // apart from the camera's noise
constexpr double kTrialS = 5;

}  // namespace

Eigen::Vector2d SimulatedObserver::true_lcd_px(DisplayId id,
                                               const Eigen::Vector3d& p_rsb_mm) const {
  const Eigen::Vector3d eye = true_eye_centre_rsb_mm(id.eye);
  if (!(p_rsb_mm.z() < eye.z())) {
    throw DeviceError(DeviceError::Kind::kOutOfRange, "the point to align lies behind the eye",
                      "choose a point inside the box");
  }
  const double s = (eye.z() - plane_z_rsb_mm(id.plane)) / (eye.z() - p_rsb_mm.z());
  const Eigen::Vector3d on_plane = eye + s * (p_rsb_mm - eye);
  return lcd_px_at(world_.model(id), on_plane.x(), on_plane.y());
}

Eigen::Vector2d SimulatedObserver::align(DisplayId id, const Eigen::Vector3d& p_rsb_mm,
                                         Deadline deadline) {
  world_.faults.meet("observer's keys", deadline);
  const PanelModel& m = world_.model(id);
  const Eigen::Vector2d truth = true_lcd_px(id, p_rsb_mm);
  if (truth.x() < -0.5 || truth.y() < -0.5 || truth.x() > m.lcd_width_px - 0.5 ||
      truth.y() > m.lcd_height_px - 0.5) {
    throw DeviceError(DeviceError::Kind::kOutOfRange,
                      "the point cannot be covered by display " + to_string(id),
                      "choose a point that the eye sees through the lit area");
  }
  const Nanoseconds done = world_.clock.in(Duration::of(kTrialS)).at_ns;
  if (done > deadline.at_ns) {
    world_.clock.wait_until(deadline.at_ns);
    throw DeviceError(DeviceError::Kind::kTimeout, "the observer did not finish in time",
                      "allow 5 s for each alignment");
  }
  world_.clock.wait_until(done);
  RandomStream random(world_.seed ^ kObserverSeed, trial_++);
  const double sigma_mm =
      m.distance.value() * std::tan(noise_arcmin_ / 60 * std::numbers::pi / 180);
  const double dx = random.normal() * sigma_mm, dy = random.normal() * sigma_mm;
  return truth +
         Eigen::Vector2d(dx * m.lcd_width_px / m.width_mm, dy * m.lcd_height_px / m.height_mm);
}

}  // namespace wheatstone
