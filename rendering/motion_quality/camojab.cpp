#include "rendering/motion_quality/camojab.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/error.h"
#include "rendering/motion_quality/camojab_parts.h"

namespace wheatstone {
namespace {

using camojab::kHalf;

// Energies and sensitivities are even in ky, so the evaluation works on folded arrays of 257 rows,
// |ky| = 0..256, the energies of +ky and -ky added. 512 columns as ever: motion shifts them.
constexpr int kFoldedRows = kHalf + 1;

/// x^beta. Good to a few units in the last place, and vectorised, unlike std::pow. 0 stays 0.
template <class Derived>
auto power(const Eigen::ArrayBase<Derived>& x, double beta) {
  return (beta * x.log()).exp();
}

/// mean-free sum over +-ky of spectrum^beta for the bins |kx| <= columns, |ky| <= rows.
CamojabSpectrum folded_energy(const CamojabSpectrum& spectrum, double beta, int columns = kHalf,
                              int rows = kHalf) {
  CamojabSpectrum energy = CamojabSpectrum::Zero(kFoldedRows, kCamojabSize);
  const int first = kHalf - columns, count = std::min(2 * columns + 1, kCamojabSize - first);
  for (int ky = -rows; ky <= std::min(rows, kHalf - 1); ++ky)
    energy.row(std::abs(ky)).segment(first, count) +=
        power(spectrum.row(ky + kHalf).segment(first, count), beta);
  return energy;
}

/// out[k] = sum of in[k + offset] along the columns, 0 outside.
CamojabSpectrum sum_of_replicas_x(const CamojabSpectrum& in, const std::vector<int>& offsets) {
  CamojabSpectrum out = CamojabSpectrum::Zero(in.rows(), in.cols());
  for (const int offset : offsets) {
    const auto overlap = std::max<Eigen::Index>(in.cols() - std::abs(offset), 0);
    if (offset >= 0)
      out.leftCols(overlap) += in.rightCols(overlap);
    else
      out.rightCols(overlap) += in.leftCols(overlap);
  }
  return out;
}
CamojabSpectrum sum_of_replicas_y(const CamojabSpectrum& in, const std::vector<int>& offsets) {
  CamojabSpectrum out = CamojabSpectrum::Zero(in.rows(), in.cols());
  for (const int offset : offsets) {
    const auto overlap = std::max<Eigen::Index>(in.rows() - std::abs(offset), 0);
    if (offset >= 0)
      out.topRows(overlap) += in.bottomRows(overlap);
    else
      out.bottomRows(overlap) += in.topRows(overlap);
  }
  return out;
}

CamojabSpectrum mip_blurred(const CamojabModel& model, const CamojabSpectrum& amplitude,
                            double mip_level, double rate_x, double rate_y) {
  const Eigen::ArrayXd gain = camojab::mip_gain(model, mip_level, std::min(rate_x, rate_y));
  return (amplitude.rowwise() * gain.transpose()).colwise() * gain;
}

/// S^beta of the folded bins.
CamojabSpectrum folded_sensitivity(const CamojabModel& model, const CamojabConditions& c,
                                   double omega_hz) {
  const auto weight = [&](double radius_bins) {
    const double rho_cpd = radius_bins * c.ppd / kCamojabSize;
    return std::pow(camojab::sensitivity(rho_cpd, omega_hz, c.luminance_cd_m2), model.weights.beta);
  };
  CamojabSpectrum folded(kFoldedRows, kCamojabSize);
  if (model.radius == CamojabModel::Radius::kLargerAxis) {
    Eigen::ArrayXd by_radius(kFoldedRows);
    for (int r = 0; r <= kHalf; ++r) by_radius[r] = weight(r);
    for (int ky = 0; ky <= kHalf; ++ky)
      for (int k = 0; k < kCamojabSize; ++k)
        folded(ky, k) = by_radius[std::max(std::abs(k - kHalf), ky)];
    return folded;
  }
  for (int ky = 0; ky <= kHalf; ++ky)
    for (int kx = ky; kx <= kHalf; ++kx) {
      const double w = weight(camojab::radius_bins(model, kx, ky));
      for (const auto& [row, column] : {std::pair{ky, kx}, std::pair{kx, ky}}) {
        folded(row, kHalf - column) = w;
        if (column < kHalf) folded(row, kHalf + column) = w;
      }
    }
  return folded;
}

/// What mip level and shading rates leave of a texture, folded.
CamojabSpectrum retained_energy(const CamojabModel& model, const CamojabSpectrum& amplitude,
                                double mip_level, double rate_x, double rate_y) {
  const CamojabSpectrum blurred = mip_blurred(model, amplitude, mip_level, rate_x, rate_y);
  const CamojabSpectrum aliased =
      sum_of_replicas_y(sum_of_replicas_x(blurred, camojab::replica_offsets(model, rate_x)),
                        camojab::replica_offsets(model, rate_y));
  return folded_energy(aliased, model.weights.beta, camojab::retained_bins(model, rate_x),
                       camojab::retained_bins(model, rate_y));
}

CamojabQuality quality_of(const CamojabModel& model, const CamojabSpectrum& reference,
                          const CamojabSpectrum& retained, const CamojabConditions& c) {
  constexpr double kBins = double(kCamojabSize) * kCamojabSize;
  const CamojabSpectrum static_weight = folded_sensitivity(model, c, 0);
  const Eigen::ArrayXd by_column = (retained * static_weight).colwise().sum();
  const double blurred = (by_column * camojab::motion_gain(model, c).pow(model.weights.beta)).sum();
  const double spatial = ((reference * static_weight).sum() - blurred) / kBins;

  double temporal = 0;
  const int seen = kCamojabSize - camojab::alias_shift_bins(model, c);  // columns still inside
  if (model.judder && seen > 0)
    temporal =
        (retained.leftCols(seen) * folded_sensitivity(model, c, c.refresh_hz).rightCols(seen))
            .sum() /
        kBins;
  return camojab::quality(model.weights, spatial, temporal);
}

double energy(const CamojabSpectrum& spectrum, double beta) {
  return spectrum.pow(beta).mean();
}

}  // namespace

CamojabTexture::CamojabTexture(const cv::Mat1d& grey) {
  if (grey.empty()) throw ArgumentError("the texture is empty", "give one of at least one texel");
  for (int r = 0; r < grey.rows; ++r)
    for (int c = 0; c < grey.cols; ++c)
      if (!std::isfinite(grey(r, c)))
        throw ArgumentError(
            fmt::format("the texture holds {} in column {}, row {}", grey(r, c), c, r),
            "give finite values, 0..1");
  const cv::Rect used(0, 0, std::min(grey.cols, kCamojabSize), std::min(grey.rows, kCamojabSize));
  cv::Mat1d padded = cv::Mat1d::zeros(kCamojabSize, kCamojabSize);
  grey(used).copyTo(padded(used));
  cv::Mat2d spectrum;
  cv::dft(padded, spectrum, cv::DFT_COMPLEX_OUTPUT);
  auto amplitude = std::make_shared<CamojabSpectrum>(kCamojabSize, kCamojabSize);
  for (int r = 0; r < kCamojabSize; ++r)
    for (int c = 0; c < kCamojabSize; ++c) {
      const cv::Vec2d& bin = spectrum((r + kHalf) % kCamojabSize, (c + kHalf) % kCamojabSize);
      (*amplitude)(r, c) = std::hypot(bin[0], bin[1]);
    }
  amplitude_ = std::move(amplitude);
}

CamojabModel CamojabModel::preset(MotionQualityPreset preset) {
  CamojabModel model;
  if (preset == MotionQualityPreset::kPublished) {
    model.radius = Radius::kEuclidean;
    model.comb = Comb::kFullIntervalTwoSides;
    model.alias_position = 1;
  }
  return model;
}

Camojab::Camojab(CamojabTexture texture, CamojabModel model)
    : texture_(std::move(texture)),
      model_(model),
      reference_energy_(folded_energy(texture_.amplitude(), model.weights.beta)) {}

CamojabQuality Camojab::evaluate(const CamojabConditions& c) const {
  camojab::require_valid(c, "");
  return quality_of(model_, reference_energy_,
                    retained_energy(model_, texture_.amplitude(), c.mip_level, c.shading_rate_x,
                                    c.shading_rate_y),
                    c);
}

std::vector<CamojabQuality> Camojab::evaluate(std::span<const CamojabConditions> all) const {
  std::map<std::tuple<double, double, double>, std::vector<std::size_t>> sharing;
  for (std::size_t i = 0; i < all.size(); ++i) {
    camojab::require_valid(all[i], fmt::format("conditions {}: ", i));
    sharing[{all[i].mip_level, all[i].shading_rate_x, all[i].shading_rate_y}].push_back(i);
  }
  const std::vector groups(sharing.begin(), sharing.end());
  std::vector<CamojabQuality> out(all.size());
  tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t g) {
    const auto& [mip_level, rate_x, rate_y] = groups[g].first;
    const std::vector<std::size_t>& members = groups[g].second;
    const CamojabSpectrum retained =
        retained_energy(model_, texture_.amplitude(), mip_level, rate_x, rate_y);
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t m) {
      out[members[m]] = quality_of(model_, reference_energy_, retained, all[members[m]]);
    });
  });
  return out;
}

CamojabStages Camojab::stages(const CamojabConditions& c) const {
  camojab::require_valid(c, "");
  const double beta = model_.weights.beta;
  const auto sensitivity = [&](double omega_hz) {
    CamojabSpectrum s(kCamojabSize, kCamojabSize);
    for (int ky = -kHalf; ky < kHalf; ++ky)
      for (int kx = -kHalf; kx < kHalf; ++kx)
        s(ky + kHalf, kx + kHalf) =
            camojab::sensitivity(camojab::radius_bins(model_, kx, ky) * c.ppd / kCamojabSize,
                                 omega_hz, c.luminance_cd_m2);
    return s;
  };
  const CamojabSpectrum static_sensitivity = sensitivity(0);
  const auto weighted_energy = [&](const CamojabSpectrum& x) {
    return energy(x * static_sensitivity, beta);
  };

  CamojabStages out;
  out.reference = energy(texture_.amplitude(), beta);
  out.reference_weighted = weighted_energy(texture_.amplitude());

  CamojabSpectrum x =
      mip_blurred(model_, texture_.amplitude(), c.mip_level, c.shading_rate_x, c.shading_rate_y);
  out.mip_blur = energy(x, beta);
  out.mip_blur_weighted = weighted_energy(x);

  x = sum_of_replicas_x(x, camojab::replica_offsets(model_, c.shading_rate_x));
  x = sum_of_replicas_y(x, camojab::replica_offsets(model_, c.shading_rate_y));
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
          ? energy(sum_of_replicas_x(x, {-out.alias_shift_bins}) * sensitivity(c.refresh_hz), beta)
          : 0;

  x.rowwise() *= camojab::motion_gain(model_, c).transpose();
  out.motion_blur_weighted = weighted_energy(x);
  out.result =
      camojab::quality(model_.weights, out.reference_weighted - out.motion_blur_weighted, temporal);
  return out;
}

}  // namespace wheatstone
