#include "sim/spectroradiometer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/colour.h"
#include "core/random.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint64_t kMeterSeed = 0x6d65746572ULL;  // apart from the other devices' noise
constexpr double kEnough = 2;                          // cd s/m^2 that it integrates for
constexpr double kTooLittle = 0.01;                    // below this it gives up
constexpr double kShortestS = 0.005;
constexpr double kShotNoise = 0.002;  // relative, at kEnough
constexpr double kReadNoise = 1e-8;   // W s/(sr m^2 nm)
constexpr double kWidthNm = 12;       // sigma of each primary
constexpr std::array<double, 3> kPeaksNm = {630, 532, 450};

SpectralRadiance primary(double peak_nm) {
  SpectralRadiance s{kMeterFirstNm, kMeterStepNm, {}};
  for (double nm = kMeterFirstNm; nm <= kMeterLastNm; nm += kMeterStepNm)
    s.values.push_back(std::exp(-0.5 * std::pow((nm - peak_nm) / kWidthNm, 2)));
  return s;
}

}  // namespace

SpectralRadiance spectrum_of(const Eigen::Vector3d& rgb_cd_m2) {
  static const std::array<SpectralRadiance, 3> kPrimaries = {
      primary(kPeaksNm[0]), primary(kPeaksNm[1]), primary(kPeaksNm[2])};
  Eigen::Matrix3d xyz_of_primaries;
  for (int i = 0; i < 3; ++i)
    xyz_of_primaries.col(i) = xyz_cd_m2(kPrimaries[static_cast<std::size_t>(i)]);
  const Eigen::Vector3d weight =
      xyz_of_primaries.inverse() * xyz_from_rgb(bt709_primaries()) * rgb_cd_m2;
  SpectralRadiance out{kMeterFirstNm, kMeterStepNm,
                       std::vector<double>(kPrimaries[0].values.size())};
  for (std::size_t k = 0; k < out.values.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i)
      out.values[k] += weight[static_cast<int>(i)] * kPrimaries[i].values[k];
  return out;
}

Eigen::Vector3d SpectroradiometerModel::rgb_cd_m2() const {
  const double radius = std::tan(kMeterFieldDeg / 2 * std::numbers::pi / 180);  // per mm away
  if (display_) {
    const RgbImage light = world_.panel_light(*display_);
    const PanelModel& m = world_.model(*display_);
    const double radius_px = m.distance.value() * radius * m.lcd_width_px / m.width_mm;
    const int half = std::max(1, static_cast<int>(radius_px));
    const cv::Rect spot(light.width() / 2 - half, light.height() / 2 - half, 2 * half, 2 * half);
    const cv::Scalar mean = cv::mean(light.pixels(spot));
    return gain_ * Eigen::Vector3d(mean[0], mean[1], mean[2]);
  }
  // Rays spread evenly over the field (Vogel's spiral).
  constexpr int kRays = 32 * Scene::kPacket;
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int first = 0; first < kRays; first += Scene::kPacket) {
    std::array<Ray, Scene::kPacket> rays;
    std::array<Eigen::Vector3f, Scene::kPacket> seen;
    for (int i = 0; i < Scene::kPacket; ++i) {
      const double r = radius * std::sqrt((first + i + 0.5) / kRays), a = turn * (first + i);
      rays[static_cast<std::size_t>(i)] = {
          Eigen::Vector3d(kBoxSizeMm.x() / 2, kBoxSizeMm.y() / 2, kEyeZMm).cast<float>(),
          Eigen::Vector3d(r * std::cos(a), r * std::sin(a), -1).cast<float>()};
    }
    world_.scene.radiance(rays.data(), Scene::kPacket, world_.light, seen.data());
    for (const Eigen::Vector3f& rgb : seen) sum += rgb.cast<double>();
  }
  return gain_ * sum / kRays;
}

SpectroradiometerModel::Exposure SpectroradiometerModel::expose(double longest_s, int average,
                                                                std::uint64_t n) const {
  const Eigen::Vector3d rgb = rgb_cd_m2();
  Exposure out;
  out.spectrum = spectrum_of(rgb);
  const double luminance = xyz_cd_m2(out.spectrum).y();
  out.integration_s =
      std::clamp(kEnough / std::max(luminance, 1e-9), kShortestS, std::max(longest_s, kShortestS));
  const double light = luminance * out.integration_s;
  if (luminance > kMeterBrightestCdM2) out.outcome = Exposure::Outcome::kTooBright;
  if (light < kTooLittle) out.outcome = Exposure::Outcome::kTooDark;
  if (out.outcome != Exposure::Outcome::kGood) return out;
  RandomStream random(world_.seed ^ kMeterSeed, n);
  const double shot = kShotNoise * std::sqrt(kEnough / light),
               read = kReadNoise / out.integration_s;
  for (double& v : out.spectrum.values)
    v += (shot * v * random.normal() + read * random.normal()) / std::sqrt(average);
  return out;
}

SpectroradiometerRange SimulatedSpectroradiometer::range() const {
  return {kMeterFirstNm, kMeterLastNm, kMeterStepNm, kMeterFloorCdM2, Duration::of(60)};
}

void SimulatedSpectroradiometer::configure(const Settings& settings, Deadline deadline) {
  require_valid(settings, range().longest_integration);
  world_.faults.meet("spectroradiometer", deadline);
  settings_ = settings;
}

SpectralReading SimulatedSpectroradiometer::measure(Deadline deadline) {
  world_.faults.meet("spectroradiometer", deadline);
  aiming_ = false;
  const auto exposure =
      model_.expose(settings_.longest_integration.value(), settings_.average, measurements_++);
  const Nanoseconds done =
      world_.clock
          .in(Duration::of(kMeterOverheadS + 2 * settings_.average * exposure.integration_s))
          .at_ns;
  world_.clock.wait_until(std::min(done, deadline.at_ns));
  if (done > deadline.at_ns)
    throw DeviceError(Kind::kTimeout, "the simulated spectroradiometer is not done in time",
                      "allow more time, or a shorter integration");
  using Outcome = SpectroradiometerModel::Exposure::Outcome;
  if (exposure.outcome == Outcome::kTooBright)
    throw DeviceError(Kind::kTooBright, "the simulated spectroradiometer is overexposed",
                      "show less light");
  if (exposure.outcome == Outcome::kTooDark)
    throw DeviceError(Kind::kTooDark, "the simulated spectroradiometer is underexposed",
                      "show more light, or integrate longer");
  SpectralReading reading;
  reading.spectrum = exposure.spectrum;
  reading.xyz_cd_m2 = xyz_cd_m2(reading.spectrum);
  reading.device_xyz_cd_m2 = reading.xyz_cd_m2;
  reading.integration = Duration::of(exposure.integration_s);
  reading.below_floor = reading.xyz_cd_m2.y() < kMeterFloorCdM2;
  return reading;
}

void SimulatedSpectroradiometer::aim(bool on, Deadline deadline) {
  world_.faults.meet("spectroradiometer", deadline);
  aiming_ = on;
}

}  // namespace wheatstone
