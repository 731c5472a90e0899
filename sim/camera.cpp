#include "sim/camera.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <sstream>

#include "core/random.h"
#include "hardware/device_error.h"

namespace wheatstone {
namespace {

using Eigen::Vector3f;

constexpr int kNodePx = 4;           // the table errs by less than 1e-4 px
constexpr int kSamples = 4;          // per photosite, a rotated grid
constexpr int kMarkerSamples = 256;  // 16x16: a marker's edge is a step from dark to bright
constexpr double kMarkerReachPx = 4;
constexpr double kReadoutS = 0.2;
constexpr std::size_t kCachedImages = 2;
constexpr std::array<std::array<float, 2>, kSamples> kOffsets = {
    {{-0.375F, -0.125F}, {0.125F, -0.375F}, {0.375F, 0.125F}, {-0.125F, 0.375F}}};

// Offset of sample i of a photosite from its centre.
std::array<float, 2> offset(int i, int samples) {
  if (samples == kSamples) return kOffsets[static_cast<std::size_t>(i)];
  return {(static_cast<float>(i % 16) + 0.5F) / 16 - 0.5F,
          (static_cast<float>(i / 16) + 0.5F) / 16 - 0.5F};
}

}  // namespace

SimulatedCamera::SimulatedCamera(World& world, bool noise) : world_(world), noise_(noise) {}

void SimulatedCamera::build_lens_table() {
  const CameraProfile& p = world_.camera_profile;
  lens_.create((p.intrinsics.height_px + kNodePx - 1) / kNodePx + 3,
               (p.intrinsics.width_px + kNodePx - 1) / kNodePx + 3);
  tbb::parallel_for(0, lens_.rows, [&](int j) {
    for (int i = 0; i < lens_.cols; ++i) {
      const double y = ((j - 1) * kNodePx - p.intrinsics.cy_px) / p.intrinsics.fy_px;
      const double x = ((i - 1) * kNodePx - p.intrinsics.cx_px) / p.intrinsics.fx_px;
      const Eigen::Vector2d xy = undistort(p.distortion, {x, y});
      lens_(j, i) = {static_cast<float>(xy.x()), static_cast<float>(xy.y())};
    }
  });
}

Eigen::Vector2f SimulatedCamera::normalised_at(float x_px, float y_px) const {
  const float x = x_px / kNodePx + 1, y = y_px / kNodePx + 1;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const cv::Vec2f v = (1 - fy) * ((1 - fx) * lens_(j, i) + fx * lens_(j, i + 1)) +
                      fy * ((1 - fx) * lens_(j + 1, i) + fx * lens_(j + 1, i + 1));
  return {v[0], v[1]};
}

cv::Mat1f SimulatedCamera::trace() const {
  const CameraProfile& profile = world_.camera_profile;
  const BoxLight& light = world_.light;
  const RigidTransform T_camera_rsb = true_T_camera_rsb(world_.carriage_mm);
  const Eigen::Matrix3f R_rsb_camera = T_camera_rsb.R.transpose().cast<float>();
  const Vector3f centre = camera_centre(T_camera_rsb).cast<float>();
  const Eigen::Matrix3f colour = profile.camera_from_bt709.cast<float>();
  const int width = profile.intrinsics.width_px, height = profile.intrinsics.height_px;

  // Near a lit marker more samples are spent; with the ceiling dark all else stays black.
  cv::Mat1b near_marker(height, width, std::uint8_t{0});
  const double reach = kMarkerReachPx + profile.intrinsics.fx_px * kMarkerRadiusMm / centre.z();
  for (unsigned i = 0; i < kMarkerCount; ++i) {
    if (!(light.marker_mask >> i & 1U)) continue;
    const Eigen::Vector2d q = project(profile.intrinsics, profile.distortion,
                                      T_camera_rsb * marker_positions_rsb_mm()[i]);
    const cv::Rect around(
        cv::Point(static_cast<int>(q.x() - reach), static_cast<int>(q.y() - reach)),
        cv::Point(static_cast<int>(q.x() + reach) + 1, static_cast<int>(q.y() + reach) + 1));
    near_marker(around & cv::Rect(0, 0, width, height)).setTo(1);
  }

  cv::Mat1f image(height, width, 0.0F);
  tbb::parallel_for(0, height, [&](int y) {
    Ray rays[Scene::kPacket];
    Vector3f rgb[Scene::kPacket];
    int pixel[Scene::kPacket];  // column each ray of the packet belongs to
    float weight[Scene::kPacket];
    int filled = 0;
    const auto flush = [&] {
      if (filled == 0) return;
      world_.scene.radiance(rays, filled, light, rgb);
      for (int k = 0; k < filled; ++k) {
        const int c = bayer_colour(profile.pattern, y, pixel[k]);
        image(y, pixel[k]) += weight[k] * colour.row(c).dot(rgb[k]);
      }
      filled = 0;
    };
    for (int x = 0; x < width; ++x) {
      if (light.led_drive <= 0 && !near_marker(y, x)) continue;
      const int samples = near_marker(y, x) ? kMarkerSamples : kSamples;
      for (int s = 0; s < samples; ++s) {
        const auto [dx, dy] = offset(s, samples);
        const Eigen::Vector2f n =
            normalised_at(static_cast<float>(x) + dx, static_cast<float>(y) + dy);
        rays[filled] = {centre, R_rsb_camera * Vector3f(n.x(), n.y(), 1)};
        pixel[filled] = x;
        weight[filled] = 1.0F / static_cast<float>(samples);
        if (++filled == Scene::kPacket) flush();
      }
    }
    flush();
  });
  return image;
}

cv::Mat1f SimulatedCamera::optical_image_cd_m2() {
  const auto found = std::find_if(cache_.begin(), cache_.end(), [&](const Cached& c) {
    return c.carriage_mm == world_.carriage_mm && c.light == world_.light;
  });
  if (found != cache_.end()) return found->image_cd_m2;
  if (lens_.empty()) build_lens_table();
  cache_.push_front({world_.carriage_mm, world_.light, trace()});
  if (cache_.size() > kCachedImages) cache_.pop_back();
  return cache_.front().image_cd_m2;
}

Duration SimulatedCamera::frame_duration(Duration exposure) const {
  return Duration::of(exposure.value() + kReadoutS);
}

DeviceIdentity SimulatedCamera::identity() const {
  return {"simulated", "twin of the capture camera", world_.camera_profile.serial, "", ""};
}

Duration SimulatedCamera::offered_exposure(Duration exposure) const {
  const double t = exposure.value();
  if (!(t >= 1.0 / 8000 * 0.999 && t <= 30)) {
    std::ostringstream problem;
    problem << "the camera cannot expose for " << t << " s";
    throw DeviceError(DeviceError::Kind::kOutOfRange, problem.str(), "use 1/8000 s to 30 s");
  }
  return exposure;
}

RawFrame SimulatedCamera::expose(Duration exposure, Deadline deadline) {
  const double t = offered_exposure(exposure).value();
  world_.faults.meet("camera", deadline);
  const Nanoseconds triggered = world_.clock.now_ns(),
                    done = world_.clock.in(frame_duration(exposure)).at_ns;
  if (done > deadline.at_ns) {
    world_.clock.wait_until(deadline.at_ns);
    throw DeviceError(DeviceError::Kind::kTimeout, "the camera did not deliver in time",
                      "allow the exposure and 0.2 s of readout");
  }
  const cv::Mat1f optical = optical_image_cd_m2();
  const CameraProfile& p = world_.camera_profile;
  RawFrame frame{{cv::Mat1w(optical.size()), p.pattern}, exposure, 1, p.serial, triggered, {}, {}};
  const double gain = p.dn_per_cd_m2_s * t;
  const double electronic = std::hypot(p.read_noise_e, p.adc_noise);  // at ISO 100, in k
  const std::uint64_t what = stream_of({std::bit_cast<std::uint64_t>(world_.carriage_mm),
                                        std::bit_cast<std::uint64_t>(world_.light.led_drive),
                                        world_.light.marker_mask, std::bit_cast<std::uint64_t>(t)});
  const std::uint64_t noise = stream_of({what, taken_[what]++});
  tbb::parallel_for(0, optical.rows, [&](int y) {
    RandomStream random(world_.seed, noise + static_cast<std::uint64_t>(y));
    for (int x = 0; x < optical.cols; ++x) {
      double signal = gain * optical(y, x);
      if (noise_) {
        const auto c = static_cast<std::size_t>(bayer_colour(p.pattern, y, x));
        const double k = p.dn_per_electron[c];
        const double photons = random.poisson(signal / k);
        signal = k * (photons + electronic * random.normal());
      }
      const double dn = std::clamp(std::round(p.black_dn + signal), 0.0, double(p.white_dn));
      frame.mosaic.dn(y, x) = static_cast<std::uint16_t>(dn);
    }
  });
  world_.clock.wait_until(done);
  return frame;
}

}  // namespace wheatstone
