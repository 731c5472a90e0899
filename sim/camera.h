#pragma once
// The simulated still camera.

#include <cstdint>
#include <deque>
#include <map>
#include <opencv2/core.hpp>
#include <vector>

#include "hardware/still_camera.h"
#include "sim/world.h"

namespace wheatstone {

class SimulatedCamera final : public StillCamera {
 public:
  SimulatedCamera(World& world, bool noise);

  const CameraProfile& profile() const { return world_.camera_profile; }
  DeviceIdentity identity() const override;
  /// Any from 1/8000 s to 30 s.
  Duration offered_exposure(Duration) const override;
  Duration frame_duration(Duration exposure) const override;
  std::uintmax_t largest_file(std::uintmax_t) const override { return 0; }
  /// The noise depends on what is seen for how long, and how often that
  /// was taken already; not on what else was taken.
  RawFrame expose(Duration, Deadline) override;
  void abort() noexcept override {}  // exposures are over when they return

  /// Noise-free camera-space colour per photosite in cd/m^2, as the lens images it now.
  cv::Mat1f optical_image_cd_m2();

 private:
  struct Cached {
    double carriage_mm;
    BoxLight light;
    cv::Mat1f image_cd_m2;
  };

  // Undistorted normalised coordinates of a pixel position, from the table of nodes.
  Eigen::Vector2f normalised_at(float x_px, float y_px) const;
  void build_lens_table();
  cv::Mat1f trace() const;

  World& world_;
  bool noise_;
  std::map<std::uint64_t, std::uint64_t> taken_;  // equal frames so far
  cv::Mat2f lens_;            // nodes every kNodePx pixels, the first at (-kNodePx, -kNodePx)
  std::deque<Cached> cache_;  // newest first
};

}  // namespace wheatstone
