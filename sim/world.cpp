#include "sim/world.h"

#include <bit>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

constexpr std::uint64_t kStageSeed = 0x7374616765ULL;  // apart from the camera's noise
constexpr double kSettleSigmaMm = 0.005;

double checked_scale(double scale) {
  if (scale > 0 && scale <= 1) return scale;
  std::ostringstream problem;
  problem << "scale " << scale << " is outside (0, 1]";
  throw ArgumentError(problem.str(), "use for example 0.25");
}

}  // namespace

World::World(const std::string& name, double pixel_scale, std::uint64_t seed_)
    : seed(seed_),
      scene_name(name),
      scale(checked_scale(pixel_scale)),
      scene(name),
      camera_profile(true_camera_profile(pixel_scale)) {
  for (const DisplayId id : kDisplays) panel_models.push_back(true_panel_model(id, scale));
}

double World::move_carriage(double mm) {
  const int side = (mm > commanded_mm_) - (mm < commanded_mm_);
  if (side == 0) return encoder_mm_;
  RandomStream random(seed ^ kStageSeed,
                      stream_of({std::bit_cast<std::uint64_t>(mm), static_cast<std::uint64_t>(side),
                                 visits_[{mm, side}]++}));
  commanded_mm_ = mm;
  encoder_mm_ = mm + kSettleSigmaMm * random.normal();
  // The encoder sits on the motor and does not see the backlash.
  carriage_mm = encoder_mm_ + (side < 0 ? backlash_mm : 0);
  return encoder_mm_;
}

void World::home_carriage() {
  commanded_mm_ = encoder_mm_ = carriage_mm = 0;
}

RigidTransform true_T_camera_rsb(double carriage_mm) {
  constexpr double kDegree = std::numbers::pi / 180;
  const Eigen::Vector3d centre(101.5 + carriage_mm, 130, 550);
  const Eigen::Matrix3d mount = (Eigen::AngleAxisd(0.2 * kDegree, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(-0.3 * kDegree, Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(0.4 * kDegree, Eigen::Vector3d::UnitY()))
                                    .toRotationMatrix();
  const Eigen::Matrix3d R = mount * straight_R_camera_rsb();
  return {R, -(R * centre)};
}

CameraProfile true_camera_profile(double scale) {
  CameraProfile p;
  p.serial = "SIM-A7RM3";
  // An even size keeps whole Bayer cells.
  p.intrinsics.width_px = 2 * static_cast<int>(std::lround(7360 * scale / 2));
  p.intrinsics.height_px = 2 * static_cast<int>(std::lround(4912 * scale / 2));
  p.intrinsics.fx_px = p.intrinsics.fy_px = 11244 * scale;
  p.intrinsics.cx_px = (3679.5 + 20 + 0.5) * scale - 0.5;
  p.intrinsics.cy_px = (2455.5 - 13 + 0.5) * scale - 0.5;
  p.distortion = {-0.05, 0.01, 2e-4, -1e-4, 0};
  p.pattern = BayerPattern::kRggb;
  p.black_dn = 512;
  p.white_dn = 16383;
  p.dn_per_cd_m2_s = (p.white_dn - p.black_dn) * 60.0 / 1000;  // 1000 cd/m^2 fills 1/60 s
  p.camera_from_bt709 << 0.88, 0.10, 0.02, 0.04, 0.90, 0.06, 0.01, 0.09, 0.90;
  p.dn_per_electron = {0.422044, 0.384277, 0.388967};  // Sony A7R III, hdr_merge.md sec. 1
  p.read_noise_e = 0.705127;
  p.adc_noise = 3.02845;
  return p;
}

std::vector<Eigen::Vector3d> near_cross_positions_rsb_mm() {
  return {{147, 92, 360}, {223, 92, 360}, {147, 168, 360}, {223, 168, 360}};
}

}  // namespace wheatstone
