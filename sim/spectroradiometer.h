#pragma once
// A spectroradiometer at the viewer's place, looking at the middle of the box or of a display.

#include <optional>

#include "hardware/spectroradiometer.h"
#include "sim/world.h"

namespace wheatstone {

inline constexpr double kMeterFloorCdM2 = 0.1;
inline constexpr double kMeterBrightestCdM2 = 70'000;
inline constexpr double kMeterFieldDeg = 1.8;
inline constexpr double kMeterFirstNm = 380, kMeterLastNm = 780, kMeterStepNm = 1;
inline constexpr double kMeterOverheadS =
    3.6;  // of each measurement, besides twice the integration

/// Light of three narrow primaries (450, 532 and 630 nm) with the XYZ of linear BT.709 light:
/// W/(sr m^2 nm) from 380 to 780 nm.
SpectralRadiance spectrum_of(const Eigen::Vector3d& rgb_cd_m2);

/// What the instrument makes of the light: it integrates until it has enough, but not longer than
/// it may; noise from the world's seed.
class SpectroradiometerModel {
 public:
  /// `display`: none: the box. `gain`: of the light, so that a test can blind it.
  explicit SpectroradiometerModel(World& world, std::optional<DisplayId> display = {},
                                  double gain = 1)
      : world_(world), display_(display), gain_(gain) {}

  struct Exposure {
    enum class Outcome { kGood, kTooBright, kTooDark } outcome = Outcome::kGood;
    double integration_s = 0;
    SpectralRadiance spectrum;  // where it is good
  };
  /// The n-th measurement.
  Exposure expose(double longest_s, int average, std::uint64_t n) const;
  /// Mean linear BT.709 light of the spot, cd/m^2.
  Eigen::Vector3d rgb_cd_m2() const;

 private:
  World& world_;
  std::optional<DisplayId> display_;
  double gain_;
};

/// Measurements are over when they return, so that there is nothing to abort.
class SimulatedSpectroradiometer final : public Spectroradiometer {
 public:
  explicit SimulatedSpectroradiometer(World& world, std::optional<DisplayId> display = {},
                                      double gain = 1)
      : world_(world), model_(world, display, gain) {}

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the spectroradiometer", "", "", ""};
  }
  SpectroradiometerRange range() const override;
  void configure(const Settings&, Deadline) override;
  SpectralReading measure(Deadline) override;
  void aim(bool on, Deadline) override;
  void abort() noexcept override {}

  bool aiming() const { return aiming_; }

 private:
  World& world_;
  SpectroradiometerModel model_;
  Settings settings_;
  bool aiming_ = false;
  std::uint64_t measurements_ = 0;
};

}  // namespace wheatstone
