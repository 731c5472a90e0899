#include "capture/exposure_times.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr int kTiles = 16;           // across and down
constexpr int kSmallestTile_px = 8;  // of green pixels: small frames have fewer tiles
constexpr std::size_t kRank = 50;    // brighter than the 50th of the tile in the next frame
constexpr std::size_t kFewest = 25;  // pixels kept of a tile, or it is left out
constexpr double kMostUseless = 0.95;
constexpr double kMostDeviation = 2;  // of the estimate from nominal, relative
constexpr std::size_t kFewestFrames = 3;

/// The green pixels of the cells' first rows, black level subtracted.
struct GreenFrame {
  cv::Mat1d values_dn;
  cv::Mat1b valid;  // neither saturated nor in the noise
  double nominal_s, gain, scale_s;
  std::size_t index;  // in the caller's order
};

GreenFrame green_of(const RawExposure& e, const MergeOptions& options, std::size_t index) {
  const int column = bayer_colour(e.frame.pattern, 0, 0) == 1 ? 0 : 1;
  const cv::Size size(e.frame.width() / 2, e.frame.height() / 2);
  GreenFrame out{cv::Mat1d(size), cv::Mat1b(size), e.exposure.value(), e.gain, e.scale_s(), index};
  for (int r = 0; r < size.height; ++r)
    for (int c = 0; c < size.width; ++c) {
      const int dn = e.frame.dn(2 * r, 2 * c + column);
      out.values_dn(r, c) = std::max(dn - options.black_dn[static_cast<std::size_t>(column)], 1e-6);
      out.valid(r, c) = dn < options.saturation_dn;
    }
  return out;
}

/// Relative variance of a pixel, that is the variance of its logarithm.
double relative_variance(double y_dn, double gain, const MergeOptions& options) {
  if (!options.noise) return 1 / y_dn;
  const SensorNoise& n = *options.noise;
  const double k = n.dn_per_electron[1];
  const double electronic =
      n.read_noise_e * n.read_noise_e * gain * gain + n.adc_noise * n.adc_noise;
  return (y_dn * gain * k + electronic * k * k) / (y_dn * y_dn);
}

/// Normal equations of log exposures, e_later - e_earlier = log_ratio.
struct Equations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  int count = 0;
  void add(Eigen::Index earlier, Eigen::Index later, double log_ratio, double weight) {
    A(earlier, earlier) += weight;
    A(later, later) += weight;
    A(earlier, later) -= weight;
    A(later, earlier) -= weight;
    b(later) += weight * log_ratio;
    b(earlier) -= weight * log_ratio;
    ++count;
  }
};

/// A pixel of one frame beside the same of a longer one.
struct Comparison {
  std::size_t later;
  double log_ratio, weight;
};

/// Of a tile and frame i, the pixels that are valid in it and among the brightest valid ones of the
/// next frame.
std::vector<cv::Point> pixels_of_tile(const std::vector<GreenFrame>& frames, std::size_t i,
                                      const cv::Rect& tile) {
  cv::Mat1d next = frames[i + 1].values_dn(tile).clone();
  next.setTo(0, frames[i + 1].valid(tile) == 0);
  std::vector<double> sorted(next.begin(), next.end());
  std::nth_element(sorted.begin(), sorted.begin() + (kRank - 1), sorted.end(), std::greater<>());
  std::vector<cv::Point> out;
  for (int r = 0; r < tile.height; ++r)
    for (int c = 0; c < tile.width; ++c)
      if (frames[i].valid(tile.y + r, tile.x + c) && next(r, c) > sorted[kRank - 1])
        out.emplace_back(tile.x + c, tile.y + r);
  return out;
}

Equations equations_of(const std::vector<GreenFrame>& frames, const MergeOptions& options,
                       ExposurePairing pairing, bool weighted) {
  const auto compare = [&](std::size_t i, const cv::Point& p) {
    std::size_t later = pairing == ExposurePairing::kPairwise ? i + 1 : frames.size() - 1;
    while (!frames[later].valid(p)) --later;  // the next one is valid
    const double a = frames[i].values_dn(p), b = frames[later].values_dn(p);
    const double variance = relative_variance(a, frames[i].gain, options) +
                            relative_variance(b, frames[later].gain, options);
    return Comparison{later, std::log(b / a), weighted ? 1 / variance : 1};
  };
  const auto n = static_cast<Eigen::Index>(frames.size());
  Equations out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  const cv::Size size = frames[0].values_dn.size();
  const cv::Size tile(std::max(size.width / kTiles, kSmallestTile_px),
                      std::max(size.height / kTiles, kSmallestTile_px));
  for (int y = 0; y + tile.height <= size.height; y += tile.height)
    for (int x = 0; x + tile.width <= size.width; x += tile.width) {
      std::vector<std::vector<Comparison>> kept(frames.size() - 1);
      std::size_t fewest = std::numeric_limits<std::size_t>::max();
      for (std::size_t i = 0; i < kept.size(); ++i) {
        for (const cv::Point& p : pixels_of_tile(frames, i, {{x, y}, tile}))
          kept[i].push_back(compare(i, p));
        fewest = std::min(fewest, kept[i].size());
      }
      if (fewest < kFewest) continue;
      // Of every frame as many: the most certain ones, without weights the upper ones.
      for (std::size_t i = 0; i < kept.size(); ++i) {
        std::stable_sort(
            kept[i].begin(), kept[i].end(),
            [](const Comparison& a, const Comparison& b) { return a.weight > b.weight; });
        kept[i].resize(fewest);
        for (const Comparison& c : kept[i])
          out.add(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c.later), c.log_ratio,
                  c.weight);
      }
    }
  return out;
}

}  // namespace

ExposurePairing exposure_pairing_from_string(const std::string& text) {
  if (text == "pairwise") return ExposurePairing::kPairwise;
  if (text == "mst") return ExposurePairing::kMst;
  throw ArgumentError("'" + text + "' is no method", "use pairwise or mst");
}

ExposureTimes estimate_exposure_times(std::span<const RawExposure> stack,
                                      const MergeOptions& options, ExposurePairing pairing,
                                      bool weighted) {
  check_exposures(stack, options);
  if (std::min(stack[0].frame.width(), stack[0].frame.height()) < 2 * kSmallestTile_px)
    throw ArgumentError("the frames are smaller than 16 x 16 px", "give larger ones");
  ExposureTimes out;
  std::vector<GreenFrame> frames;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    out.exposure_s.push_back(stack[i].exposure.value());
    frames.push_back(green_of(stack[i], options, i));
  }
  out.estimated.assign(stack.size(), false);
  const auto shorter = [](const GreenFrame& a, const GreenFrame& b) {
    return a.scale_s < b.scale_s;
  };
  std::stable_sort(frames.begin(), frames.end(), shorter);

  // The darkest pixel of the shortest frame tells how far noise reaches around the black level.
  double darkest = 0;
  cv::minMaxLoc(stack[frames[0].index].frame.dn, &darkest);
  const double floor_dn =
      std::max(options.saturation_dn / 1000.0, std::abs(darkest - options.black_dn[0]));
  const auto note = [&](std::size_t index, const std::string& why) {
    out.note += (out.note.empty() ? "" : "; ") + ("frame " + std::to_string(index) + " " + why);
  };
  for (GreenFrame& f : frames) f.valid &= f.values_dn > floor_dn;
  std::erase_if(frames, [&](const GreenFrame& f) {
    const double useful = cv::countNonZero(f.valid) / static_cast<double>(f.valid.total());
    if (useful >= 1 - kMostUseless) return false;
    note(f.index, "is almost wholly saturated or dark");
    return true;
  });
  if (frames.size() < kFewestFrames) {
    out.note = "fewer than three frames can be compared";
    return out;
  }

  const Equations equations = equations_of(frames, options, pairing, weighted);
  out.equations = equations.count;
  // The longest frame is the anchor: log exposures relative to it.
  const auto unknowns = static_cast<Eigen::Index>(frames.size()) - 1;
  const Eigen::LDLT<Eigen::MatrixXd> solver(equations.A.topLeftCorner(unknowns, unknowns));
  const Eigen::VectorXd log_exposure = solver.solve(equations.b.head(unknowns));
  if (equations.count == 0 || solver.info() != Eigen::Success || !solver.isPositive() ||
      solver.vectorD().minCoeff() <= 1e-9 * solver.vectorD().maxCoeff()) {
    out.note = "too few pixels are well exposed in neighbouring frames";
    return out;
  }
  const GreenFrame& anchor = frames.back();
  out.estimated[anchor.index] = true;
  for (Eigen::Index i = 0; i < unknowns; ++i) {
    const GreenFrame& f = frames[static_cast<std::size_t>(i)];
    const double estimate_s =
        std::exp(log_exposure(i)) * anchor.scale_s / (f.scale_s / f.nominal_s);
    if (std::abs(estimate_s - f.nominal_s) > kMostDeviation * f.nominal_s) {
      note(f.index, "would deviate by more than 200 % from its nominal time");
      continue;
    }
    out.exposure_s[f.index] = estimate_s;
    out.estimated[f.index] = true;
  }
  return out;
}

}  // namespace wheatstone
