#include "capture/merge_cells.h"

#include <algorithm>
#include <cmath>

namespace wheatstone {
namespace {

constexpr int kFullNoiseIterations = 10;
constexpr double kSmallestVariance = 1e-12;  // DN^2; the model's is 0 for dark pixels without noise
constexpr float kDetectionLimit = 2;         // standard deviations

// The inner loops are compiled twice, for any processor and for wider vectors. Both do the same
// operations in the same order, without fused multiply-add, and so give the same bits.
#if defined(__x86_64__)
#define WHEATSTONE_AVX2 [[gnu::target("avx2")]]
const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
#else
#define WHEATSTONE_AVX2
const bool has_avx2 = false;
#endif

[[gnu::always_inline]] inline int highest_of(const std::uint16_t* a, const std::uint16_t* b,
                                             int n) {
  std::uint16_t highest = 0;
  for (int i = 0; i < n; ++i) {
    const std::uint16_t larger = a[i] > b[i] ? a[i] : b[i];
    highest = larger > highest ? larger : highest;
  }
  return highest;
}
int highest_portable(const std::uint16_t* a, const std::uint16_t* b, int n) {
  return highest_of(a, b, n);
}
WHEATSTONE_AVX2 int highest_avx2(const std::uint16_t* a, const std::uint16_t* b, int n) {
  return highest_of(a, b, n);
}

/// One row of cells that are merged from the same frames.
struct RowWork {
  int n;
  const float *black_dn, *k;  // k: null without noise parameters
  float per_time, shot_s, electronic;
  std::uint8_t flags;
  float *sum, *phi, *sigma;
  std::uint8_t* flag;
};

[[gnu::always_inline]] inline void add_codes(const std::uint16_t* dn, float scale, bool first,
                                             const RowWork& w) {
  const float* black_dn = w.black_dn;
  float* __restrict sum = w.sum;
  if (first)
    for (int i = 0; i < w.n; ++i) sum[i] = (static_cast<float>(dn[i]) - black_dn[i]) * scale;
  else
    for (int i = 0; i < w.n; ++i) sum[i] += (static_cast<float>(dn[i]) - black_dn[i]) * scale;
}
void add_portable(const std::uint16_t* dn, float scale, bool first, const RowWork& w) {
  add_codes(dn, scale, first, w);
}
WHEATSTONE_AVX2 void add_avx2(const std::uint16_t* dn, float scale, bool first, const RowWork& w) {
  add_codes(dn, scale, first, w);
}

[[gnu::always_inline]] inline void finish(const RowWork& w) {
  const float *sum = w.sum, *k = w.k;
  const float per_time = w.per_time, shot_s = w.shot_s, electronic = w.electronic;
  float* __restrict phi = w.phi;
  std::uint8_t* __restrict flag = w.flag;
  for (int i = 0; i < w.n; ++i) phi[i] = sum[i] * per_time;
  for (int i = 0; i < w.n; ++i) flag[i] = w.flags;
  if (k == nullptr) return;
  float* __restrict sigma = w.sigma;
  for (int i = 0; i < w.n; ++i) {
    const float light = phi[i] > 0 ? phi[i] : 0;
    sigma[i] = std::sqrt(k[i] * (light * shot_s + k[i] * electronic)) * per_time;
  }
  const std::uint8_t dark = w.flags | kUnderexposed, bright = w.flags;
  for (int i = 0; i < w.n; ++i) flag[i] = phi[i] < kDetectionLimit * sigma[i] ? dark : bright;
}
void finish_portable(const RowWork& w) {
  finish(w);
}
WHEATSTONE_AVX2 void finish_avx2(const RowWork& w) {
  finish(w);
}

}  // namespace

CellMerger::CellMerger(const std::vector<const RawExposure*>& frames, const MergeOptions& options)
    : options_(options), pattern_(frames[0]->frame.pattern) {
  const SensorNoise noise = options.noise.value_or(SensorNoise{});
  for (const RawExposure* e : frames) {
    const double t = e->exposure.value(), g = e->gain, area = e->aperture_area;
    const double electronic =
        noise.read_noise_e * noise.read_noise_e + noise.adc_noise * noise.adc_noise / (g * g);
    frames_.push_back({&e->frame.dn, static_cast<float>(t), static_cast<float>(1 / (g * area)),
                       static_cast<float>(t / area), static_cast<float>(electronic / area / area),
                       t, g, area});
  }
  for (int r = 0; r < 2; ++r)
    for (int c = 0; c < kBlock_px; ++c) {
      black_dn_[r][c] = static_cast<float>(options.black_dn[2 * r + c % 2]);
      k_[r][c] = static_cast<float>(noise.dn_per_electron[bayer_colour(pattern_, r, c)]);
    }
}

void CellMerger::merge_row_of_cells(int cell_row, MergedMosaic& out) {
  const cv::Size size = out.flags.size();
  for (int c = 0; c < size.width; c += kBlock_px)
    merge(cv::Rect(c, 2 * cell_row, kBlock_px, 2) & cv::Rect({0, 0}, size), out);
}

CellMerger::Usable CellMerger::usable_in(const Frame& frame, const cv::Rect& cells) const {
  const std::uint16_t* top = frame.dn->ptr<std::uint16_t>(cells.y) + cells.x;
  // Odd sizes leave half cells, whose pixels decide alone.
  const std::uint16_t* bottom = frame.dn->ptr<std::uint16_t>(cells.br().y - 1) + cells.x;
  const int highest = (has_avx2 ? highest_avx2 : highest_portable)(top, bottom, cells.width);
  if (highest < options_.saturation_dn) return Usable::kAll;
  for (int i = 0; i < cells.width; i += 2) {
    const int last = std::min(i + 1, cells.width - 1);
    if (std::max({top[i], top[last], bottom[i], bottom[last]}) < options_.saturation_dn)
      return Usable::kSome;
  }
  return Usable::kNone;
}

void CellMerger::merge(const cv::Rect& cells, MergedMosaic& out) {
  used_.clear();
  std::uint8_t flags = 0;
  for (const Frame& frame : frames_) {
    const Usable usable = usable_in(frame, cells);
    if (usable == Usable::kSome) {
      const int half = (cells.width / 2 + 1) / 2 * 2;  // whole cells
      merge({cells.x, cells.y, half, cells.height}, out);
      merge({cells.x + half, cells.y, cells.width - half, cells.height}, out);
      return;
    }
    const bool shortest = &frame == &frames_[0];
    if (shortest && usable == Usable::kNone) flags |= kSaturated;
    if (shortest || usable == Usable::kAll) used_.push_back(&frame);
  }
  if (used_.size() == 1) flags |= kSingleSource;
  merge_poisson(cells, flags, out);
  if (options_.estimator == MergeEstimator::kFullNoise) merge_full_noise(cells, out);
}

// In float: codes are exact in it, and sums of a few lose no more than 1e-7.
void CellMerger::merge_poisson(const cv::Rect& cells, std::uint8_t flags, MergedMosaic& out) const {
  float time_s = 0, shot_s = 0, electronic = 0;
  for (const Frame* f : used_) {
    time_s += f->time_s;
    shot_s += f->shot_s;
    electronic += f->electronic;
  }
  Row sum;
  for (int r = cells.y; r < cells.br().y; ++r) {
    const auto parity = static_cast<std::size_t>(r & 1);
    const RowWork work{cells.width,
                       black_dn_[parity].data(),
                       options_.noise ? k_[parity].data() : nullptr,
                       1 / time_s,
                       shot_s,
                       electronic,
                       flags,
                       sum.data(),
                       out.mosaic.values.ptr<float>(r) + cells.x,
                       options_.noise ? out.sigma_dn_s.ptr<float>(r) + cells.x : nullptr,
                       out.flags.ptr<std::uint8_t>(r) + cells.x};
    for (const Frame* f : used_)
      (has_avx2 ? add_avx2 : add_portable)(f->dn->ptr<std::uint16_t>(r) + cells.x, f->scale,
                                           f == used_[0], work);
    (has_avx2 ? finish_avx2 : finish_portable)(work);
  }
}

void CellMerger::merge_full_noise(const cv::Rect& cells, MergedMosaic& out) const {
  const SensorNoise& noise = *options_.noise;
  for (int r = cells.y; r < cells.br().y; ++r)
    for (int c = cells.x; c < cells.br().x; ++c) {
      const double k =
          noise.dn_per_electron[static_cast<std::size_t>(bayer_colour(pattern_, r, c))];
      const double black = options_.black_dn[static_cast<std::size_t>(2 * (r & 1) + (c & 1))];
      double phi = out.mosaic.values(r, c), sigma = 0;
      for (int i = 0; i < kFullNoiseIterations; ++i) {
        double weights = 0, sum = 0;
        for (const Frame* f : used_) {
          const double scale_s = f->exposure_s * f->gain * f->area;
          const double electronic = noise.read_noise_e * noise.read_noise_e * f->gain * f->gain +
                                    noise.adc_noise * noise.adc_noise;
          const double variance =
              std::max(phi * scale_s * f->gain * k + electronic * k * k, kSmallestVariance);
          weights += scale_s * scale_s / variance;
          sum += scale_s * ((*f->dn)(r, c) - black) / variance;
        }
        phi = sum / weights;
        sigma = 1 / std::sqrt(weights);
      }
      out.mosaic.values(r, c) = static_cast<float>(phi);
      out.sigma_dn_s(r, c) = static_cast<float>(sigma);
      std::uint8_t& flags = out.flags(r, c);
      flags &= static_cast<std::uint8_t>(~kUnderexposed);
      if (phi < kDetectionLimit * sigma) flags |= kUnderexposed;
    }
}

}  // namespace wheatstone
