#include <algorithm>
#include <cmath>

#include "rendering/motion_quality/camojab.h"
#include "rendering/motion_quality/camojab_parts.h"

namespace wheatstone {
namespace {

using camojab::kHalf;

double energy(const CamojabSpectrum& spectrum, double beta) {
  return spectrum.pow(beta).mean();
}

/// out[ky][kx] = sum of in[ky + offset y][kx + offset x], 0 outside.
CamojabSpectrum sum_of_replicas(const CamojabSpectrum& in, const std::vector<int>& offsets_x,
                                const std::vector<int>& offsets_y) {
  CamojabSpectrum out = CamojabSpectrum::Zero(kCamojabSize, kCamojabSize);
  const auto inside = [](int k) { return k >= 0 && k < kCamojabSize; };
  for (const int dy : offsets_y)
    for (const int dx : offsets_x)
      for (int y = 0; y < kCamojabSize; ++y)
        for (int x = 0; x < kCamojabSize; ++x)
          if (inside(y + dy) && inside(x + dx)) out(y, x) += in(y + dy, x + dx);
  return out;
}

}  // namespace

CamojabStages Camojab::stages(const CamojabConditions& c) const {
  require_valid(c);
  const double beta = model_.weights.beta;
  const StaticCsf static_csf(c.luminance_cd_m2);
  const auto sensitivity = [&](double omega_hz) {
    CamojabSpectrum s(kCamojabSize, kCamojabSize);
    for (int ky = 0; ky <= kHalf; ++ky)
      for (int kx = 0; kx <= kHalf; ++kx) {
        const double value =
            camojab::sensitivity(camojab::radius_bins(model_, kx, ky), omega_hz, c, static_csf);
        for (const int row : {-ky, ky})
          for (const int column : {-kx, kx})
            if (row < kHalf && column < kHalf) s(row + kHalf, column + kHalf) = value;
      }
    return s;
  };
  const CamojabSpectrum static_sensitivity = sensitivity(0);
  const auto weighted_energy = [&](const CamojabSpectrum& x) {
    return energy(x * static_sensitivity, beta);
  };

  CamojabStages out;
  out.reference = energy(texture_.amplitude(), beta);
  out.reference_weighted = weighted_energy(texture_.amplitude());

  CamojabSpectrum x = texture_.amplitude();
  const Eigen::ArrayXd gain =
      camojab::mip_gain(model_, c.mip_level, std::min(c.shading_rate_x, c.shading_rate_y));
  x.rowwise() *= gain.transpose();
  x.colwise() *= gain;
  out.mip_blur = energy(x, beta);
  out.mip_blur_weighted = weighted_energy(x);

  x = sum_of_replicas(x, camojab::replica_offsets(model_, c.shading_rate_x), {0});
  x = sum_of_replicas(x, {0}, camojab::replica_offsets(model_, c.shading_rate_y));
  out.aliasing_weighted = weighted_energy(x);

  const int columns = camojab::retained_bins(model_, c.shading_rate_x),
            rows = camojab::retained_bins(model_, c.shading_rate_y);
  for (int ky = -kHalf; ky < kHalf; ++ky)
    for (int kx = -kHalf; kx < kHalf; ++kx)
      if (std::abs(kx) > columns || std::abs(ky) > rows) x(ky + kHalf, kx + kHalf) = 0;
  out.clipping_weighted = weighted_energy(x);

  out.alias_shift_bins = camojab::alias_shift_bins(model_, c);
  const double temporal =
      model_.judder
          ? energy(sum_of_replicas(x, {-out.alias_shift_bins}, {0}) * sensitivity(c.refresh_hz),
                   beta)
          : 0;

  x.rowwise() *= camojab::motion_gain(model_, c).transpose();
  out.motion_blur_weighted = weighted_energy(x);
  out.result =
      camojab::quality(model_.weights, out.reference_weighted - out.motion_blur_weighted, temporal);
  return out;
}

}  // namespace wheatstone
