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

// Sensitivities are even in ky, so the evaluation works on energies folded to 257 rows |ky| =
// 0..256, those of +ky and -ky added. 512 columns as ever: motion shifts them.
constexpr int kFoldedRows = kHalf + 1;
using Line = Eigen::Array<double, 1, Eigen::Dynamic>;  // a row, kx = -256..255

/// Folds spectrum^beta; row_at(ky) yields the row ky of the spectrum. Only the bins |kx| <= columns
/// and |ky| <= rows count.
template <class RowAt>
CamojabSpectrum folded_energy(const FixedPower& power, int columns, int rows, RowAt row_at) {
  CamojabSpectrum energy = CamojabSpectrum::Zero(kFoldedRows, kCamojabSize);
  const int first = kHalf - columns, count = std::min(2 * columns + 1, kCamojabSize - first);
  for (int ky = -rows; ky <= std::min(rows, kHalf - 1); ++ky)
    energy.row(std::abs(ky)).segment(first, count) +=
        row_at(ky).segment(first, count).unaryExpr([&](double x) { return power(x); });
  return energy;
}

/// What mip level and shading rates leave of a texture: blurred, replicated, clipped. The steps
/// work along x or y alone, so each row is made at once, y first.
CamojabSpectrum retained_energy(const CamojabModel& model, const FixedPower& power,
                                const CamojabSpectrum& amplitude, const CamojabConditions& c) {
  const Line gain =
      camojab::mip_gain(model, c.mip_level, std::min(c.shading_rate_x, c.shading_rate_y));
  const std::vector<int> offsets_x = camojab::replica_offsets(model, c.shading_rate_x),
                         offsets_y = camojab::replica_offsets(model, c.shading_rate_y);
  Line blurred(kCamojabSize), row(kCamojabSize);
  const auto row_at = [&](int ky) -> const Line& {
    blurred.setZero();
    for (const int offset : offsets_y)
      if (const int y = ky + kHalf + offset; y >= 0 && y < kCamojabSize)
        blurred += gain[y] * amplitude.row(y);
    blurred *= gain;
    row.setZero();
    for (const int offset : offsets_x) {
      const int overlap = std::max(kCamojabSize - std::abs(offset), 0);
      if (offset >= 0)
        row.head(overlap) += blurred.tail(overlap);
      else
        row.tail(overlap) += blurred.head(overlap);
    }
    return row;
  };
  return folded_energy(power, camojab::retained_bins(model, c.shading_rate_x),
                       camojab::retained_bins(model, c.shading_rate_y), row_at);
}

/// S^beta of the folded bins under some conditions, row by row.
class FoldedSensitivity {
 public:
  FoldedSensitivity(const CamojabModel& model, const CamojabConditions& c, double omega_hz) {
    const StaticCsf static_csf(c.luminance_cd_m2);
    const auto weight = [&](int kx, int ky) {
      const double radius = camojab::radius_bins(model, kx, ky);
      return std::pow(camojab::sensitivity(radius, omega_hz, c, static_csf), model.weights.beta);
    };
    if (model.radius == CamojabModel::Radius::kLargerAxis) {
      by_column_.resize(1, kFoldedRows);
      for (int k = 0; k <= kHalf; ++k) by_column_(0, k) = weight(k, 0);
      return;
    }
    by_column_.resize(kFoldedRows, kFoldedRows);
    for (int ky = 0; ky <= kHalf; ++ky)
      for (int kx = ky; kx <= kHalf; ++kx) by_column_(ky, kx) = by_column_(kx, ky) = weight(kx, ky);
  }

  /// Fills `row` for kx = -256..255 at +-ky.
  void row(int ky, Line& row) const {
    const bool one_for_all = by_column_.rows() == 1;
    const auto half = by_column_.row(one_for_all ? 0 : ky);
    row.head(kFoldedRows) = half.reverse();
    row.tail(kHalf) = half.head(kHalf);
    if (one_for_all) {  // the larger axis is y for all |kx| <= ky
      const int first = kHalf - ky, count = std::min(2 * ky + 1, kCamojabSize - first);
      row.segment(first, count) = half[ky];
    }
  }

 private:
  CamojabSpectrum by_column_;  // [ky][|kx|], or one row [radius] where the larger axis decides
};

CamojabQuality quality_of(const CamojabModel& model, const CamojabSpectrum& reference,
                          const CamojabSpectrum& retained, const CamojabConditions& c) {
  const FoldedSensitivity still(model, c, 0);
  Line weight(kCamojabSize), by_column = Line::Zero(kCamojabSize);
  double undistorted = 0;
  for (int ky = 0; ky <= kHalf; ++ky) {
    still.row(ky, weight);
    undistorted += (reference.row(ky) * weight).sum();
    by_column += retained.row(ky) * weight;
  }
  const Line motion = camojab::motion_gain(model, c).pow(model.weights.beta);
  const double blurred = (by_column * motion).sum();

  double alias = 0;
  const int seen = kCamojabSize - camojab::alias_shift_bins(model, c);  // columns still inside
  if (model.judder && seen > 0) {
    const FoldedSensitivity moving(model, c, c.refresh_hz);
    for (int ky = 0; ky <= kHalf; ++ky) {
      moving.row(ky, weight);
      alias += (retained.row(ky).head(seen) * weight.tail(seen)).sum();
    }
  }
  constexpr double kBins = double(kCamojabSize) * kCamojabSize;
  return camojab::quality(model.weights, (undistorted - blurred) / kBins, alias / kBins);
}

void require(bool holds, const std::string& where, const char* what, double value,
             const char* remedy) {
  if (!holds || !std::isfinite(value))
    throw ArgumentError(fmt::format("{}{} of {} is impossible", where, what, value), remedy);
}

}  // namespace

void require_valid(const CamojabConditions& c, const std::string& where) {
  require(c.ppd > 0, where, "ppd", c.ppd, "give pixels per degree above 0");
  require(c.refresh_hz > 0, where, "refresh rate (Hz)", c.refresh_hz, "give one above 0");
  require(c.speed_deg_per_s >= 0, where, "speed (deg/s)", c.speed_deg_per_s,
          "give the magnitude of the velocity, 0 or above");
  require(c.persistence > 0 && c.persistence <= 1, where, "persistence", c.persistence,
          "give the lit part of the frame, above 0 and at most 1");
  require(c.luminance_cd_m2 > 0, where, "luminance (cd/m^2)", c.luminance_cd_m2,
          "give one above 0");
  require(c.mip_level >= 0, where, "mip level", c.mip_level, "give 0 (finest) or above");
  for (const double rate : {c.shading_rate_x, c.shading_rate_y})
    require(rate > 0 && rate <= 1, where, "shading rate", rate,
            "give the part of full resolution, above 0 and at most 1");
}

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
    : texture_(std::move(texture)), model_(model), power_(model.weights.beta) {
  require(model.weights.beta > 0 && model.weights.beta <= kCamojabMaxBeta, "", "beta",
          model.weights.beta, "give one above 0 and at most 4");
  require(model.alias_position > 0, "", "alias position", model.alias_position,
          "give one above 0, such as 0.5 or 1");
  reference_energy_ = folded_energy(
      power_, kHalf, kHalf, [this](int ky) { return texture_.amplitude().row(ky + kHalf); });
}

CamojabQuality Camojab::evaluate(const CamojabConditions& c) const {
  require_valid(c);
  return quality_of(model_, reference_energy_,
                    retained_energy(model_, power_, texture_.amplitude(), c), c);
}

std::vector<CamojabQuality> Camojab::evaluate(std::span<const CamojabConditions> all) const {
  std::map<std::tuple<double, double, double>, std::vector<std::size_t>> sharing;
  for (std::size_t i = 0; i < all.size(); ++i) {
    require_valid(all[i], fmt::format("conditions {}: ", i));
    sharing[{all[i].mip_level, all[i].shading_rate_x, all[i].shading_rate_y}].push_back(i);
  }
  const std::vector groups(sharing.begin(), sharing.end());
  std::vector<CamojabQuality> out(all.size());
  tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t g) {
    const std::vector<std::size_t>& members = groups[g].second;
    const CamojabSpectrum retained =
        retained_energy(model_, power_, texture_.amplitude(), all[members[0]]);
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t m) {
      out[members[m]] = quality_of(model_, reference_energy_, retained, all[members[m]]);
    });
  });
  return out;
}

}  // namespace wheatstone
