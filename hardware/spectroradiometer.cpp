#include "hardware/spectroradiometer.h"

#include <fmt/format.h>

#include <cmath>

#include "core/colour_matching.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kMaxLuminousEfficacy = 683;  // lm/W
constexpr double kCoarsestNm = 20;

}  // namespace

Eigen::Vector3d xyz_cd_m2(const SpectralRadiance& s) {
  if (s.values.size() < 2)
    throw ArgumentError("a spectrum has fewer than two values", "measure it again");
  if (!(s.step_nm > 0 && s.step_nm <= kCoarsestNm && std::isfinite(s.first_nm)))
    throw ArgumentError("a spectrum's wavelengths are too far apart, or no wavelengths",
                        "use a first wavelength and steps in (0, 20] nm");
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < s.values.size(); ++i) {
    if (!std::isfinite(s.values[i]))
      throw ArgumentError("a spectrum has values that are no numbers", "measure it again");
    xyz += s.values[i] * cie_1931_colour_matching(s.first_nm + static_cast<double>(i) * s.step_nm);
  }
  return kMaxLuminousEfficacy * s.step_nm * xyz;
}

bool agree(const Eigen::Vector3d& ours, const Eigen::Vector3d& theirs) {
  const double slack = 0.001 * ours.cwiseAbs().maxCoeff();  // for colours with a part near 0
  return ((ours - theirs).cwiseAbs().array() <= 0.01 * ours.cwiseAbs().array() + slack).all();
}

void require_valid(const Spectroradiometer::Settings& s, Duration longest) {
  const auto refuse = [](const std::string& problem, const std::string& remedy) {
    throw DeviceError(DeviceError::Kind::kOutOfRange, problem, remedy);
  };
  if (!(s.longest_integration.value() > 0 && s.longest_integration <= longest))
    refuse(fmt::format("the spectroradiometer cannot integrate for {:g} s",
                       s.longest_integration.value()),
           fmt::format("use up to {:g} s", longest.value()));
  if (s.average < 1 || s.average > 100)
    refuse(fmt::format("the spectroradiometer cannot average {} readings", s.average),
           "use 1 to 100");
  const double period_s = s.synchronise_to.value();
  if (period_s != 0 && !(period_s >= 1e-3 && period_s <= 1))
    refuse(fmt::format("the spectroradiometer cannot be synchronised to {:g} s", period_s),
           "use 0, or the period of the light, 0.001 s to 1 s");
}

}  // namespace wheatstone
