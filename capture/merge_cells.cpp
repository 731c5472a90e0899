#include "capture/merge_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace wheatstone {
namespace {

constexpr int kFullNoiseIterations = 10;
constexpr double kSmallestVariance = 1e-12;  // DN^2; the model's is 0 for dark pixels without noise
constexpr float kDetectionLimit = 2;         // standard deviations

using Floats = FrameTerms::Lanes;
constexpr int kLanes = sizeof(Floats) / sizeof(float);
using Ints = std::int32_t __attribute__((vector_size(32)));
using Codes = std::uint16_t __attribute__((vector_size(16)));
using Bytes = std::uint8_t __attribute__((vector_size(8)));

// The loops are compiled twice, for any processor and for wider vectors. Both do the same
// operations in the same order, without fused multiply-add, and so give the same bits.
#if defined(__x86_64__)
#define WHEATSTONE_AVX2 [[gnu::target("avx2")]]
const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
#else
#define WHEATSTONE_AVX2
const bool has_avx2 = false;
#endif

/// One of the two rows of a row of cells.
struct RowWork {
  Floats black_dn, k;  // repeated along the row; k: only with sigma
  float* phi;
  float* sigma;  // null without noise parameters
  std::uint8_t* flags;
};

/// A row of cells: for frame f, rows[2 f] and rows[2 f + 1] are its upper and lower row.
struct CellWork {
  int n;  // columns, a multiple of kLanes
  const std::uint16_t* const* rows;
  const FrameTerms* terms;
  int frames;
  int saturation_dn;
  std::array<RowWork, 2> out;
};

[[gnu::always_inline]] inline void load_codes(const std::uint16_t* from, Ints& out) {
  for (int i = 0; i < kLanes; ++i) out[i] = from[i];
}
template <class Vector>
[[gnu::always_inline]] inline void store(const Vector& value, void* to) {
  std::memcpy(to, &value, sizeof value);
}

/// Adds `value` where `usable` is -1.
[[gnu::always_inline]] inline void add(const Ints& usable, const Floats& value, Floats& sum) {
  sum += reinterpret_cast<Floats>(reinterpret_cast<Ints>(value) & usable);
}

/// Sums over the usable frames that do not differ between the two rows.
struct Sums {
  Floats per_time = {}, shot_s = {}, electronic = {};
};

template <bool kWithSigma>
[[gnu::always_inline]] inline void finish(const RowWork& row, int x, const Floats& dn,
                                          const Sums& sums, Ints flags) {
  const Floats phi = dn * sums.per_time;
  store(phi, row.phi + x);
  if constexpr (kWithSigma) {
    const Floats light = phi > 0 ? phi : Floats{};
    const Floats variance = row.k * (light * sums.shot_s + row.k * sums.electronic);
    Floats sigma;
    for (int i = 0; i < kLanes; ++i) sigma[i] = std::sqrt(variance[i]);
    sigma *= sums.per_time;
    store(sigma, row.sigma + x);
    flags |= (phi < kDetectionLimit * sigma) & kUnderexposed;
  }
  // In two steps, for which there are instructions.
  store(__builtin_convertvector(__builtin_convertvector(flags, Codes), Bytes), row.flags + x);
}

template <bool kWithSigma>
[[gnu::always_inline]] inline void merge_cells(const CellWork& w) {
  // Local copies, which the stores cannot change.
  const RowWork above = w.out[0], below = w.out[1];
  const std::uint16_t* const* rows = w.rows;
  const FrameTerms* frame_terms = w.terms;
  const int n = w.n, frames = w.frames;
  const Ints saturation_dn = Ints{} + w.saturation_dn;
  for (int x = 0; x < n; x += kLanes) {
    Floats upper_dn = {}, lower_dn = {}, time_s = {};
    Sums sums;
    Ints saturated = {}, others = {};  // -1 where the shortest frame is, where others are usable
    for (int f = 0; f < frames; ++f) {
      Ints upper, lower;
      load_codes(rows[2 * f] + x, upper);
      load_codes(rows[2 * f + 1] + x, lower);
      const Ints higher = upper > lower ? upper : lower;
      const Ints neighbour = __builtin_shufflevector(higher, higher, 1, 0, 3, 2, 5, 4, 7, 6);
      Ints usable = (higher > neighbour ? higher : neighbour) < saturation_dn;
      if (f == 0) {  // always used
        saturated = ~usable;
        usable |= -1;
      } else {
        others |= usable;
      }
      const FrameTerms& terms = frame_terms[f];
      add(usable, (__builtin_convertvector(upper, Floats) - above.black_dn) * terms.scale,
          upper_dn);
      add(usable, (__builtin_convertvector(lower, Floats) - below.black_dn) * terms.scale,
          lower_dn);
      add(usable, terms.time_s, time_s);
      if constexpr (!kWithSigma) continue;
      add(usable, terms.shot_s, sums.shot_s);
      add(usable, terms.electronic, sums.electronic);
    }
    sums.per_time = 1.0F / time_s;
    const Ints flags = (saturated & kSaturated) | (~others & kSingleSource);
    finish<kWithSigma>(above, x, upper_dn, sums, flags);
    finish<kWithSigma>(below, x, lower_dn, sums, flags);
  }
}

void merge_portable(const CellWork& w) {
  w.out[0].sigma != nullptr ? merge_cells<true>(w) : merge_cells<false>(w);
}
WHEATSTONE_AVX2 void merge_avx2(const CellWork& w) {
  w.out[0].sigma != nullptr ? merge_cells<true>(w) : merge_cells<false>(w);
}
void merge_columns(const CellWork& w) {
  (has_avx2 ? merge_avx2 : merge_portable)(w);
}

}  // namespace

CellMerger::CellMerger(const std::vector<const RawExposure*>& frames, const MergeOptions& options)
    : options_(options),
      pattern_(frames[0]->frame.pattern),
      frames_(frames),
      rows_(2 * frames.size()),
      tail_(rows_.size() * kLanes) {
  const SensorNoise noise = options.noise.value_or(SensorNoise{});
  for (const RawExposure* e : frames) {
    const double t = e->exposure.value(), g = e->gain, area = e->aperture_area;
    const double electronic =
        noise.read_noise_e * noise.read_noise_e + noise.adc_noise * noise.adc_noise / (g * g);
    const auto lanes = [](double value) { return Floats{} + static_cast<float>(value); };
    terms_.push_back(
        {lanes(1 / (g * area)), lanes(t), lanes(t / area), lanes(electronic / area / area)});
  }
}

void CellMerger::merge_row_of_cells(int cell_row, MergedMosaic& out) {
  // Odd sizes leave half cells, whose pixels decide alone: they stand in for the missing ones.
  const int top = 2 * cell_row, bottom = std::min(top + 1, out.flags.rows - 1);
  merge_poisson(top, bottom, out);
  if (options_.estimator == MergeEstimator::kFullNoise) merge_full_noise(top, bottom, out);
}

// In float: codes are exact in it, and sums of a few lose no more than 1e-7.
void CellMerger::merge_poisson(int top, int bottom, MergedMosaic& out) {
  const int width = out.flags.cols, whole = width / kLanes * kLanes, rest = width - whole;
  const SensorNoise noise = options_.noise.value_or(SensorNoise{});
  CellWork work{
      whole, rows_.data(), terms_.data(), static_cast<int>(frames_.size()), options_.saturation_dn,
      {}};
  for (int r = 0; r < 2; ++r) {
    RowWork& row = work.out[static_cast<std::size_t>(r)];
    const int y = r == 0 ? top : bottom;
    for (int c = 0; c < kLanes; ++c) {
      row.black_dn[c] =
          static_cast<float>(options_.black_dn[static_cast<std::size_t>(2 * (y & 1) + (c & 1))]);
      row.k[c] = static_cast<float>(
          noise.dn_per_electron[static_cast<std::size_t>(bayer_colour(pattern_, y, c))]);
    }
    row.phi = out.mosaic.values[y];
    row.sigma = options_.noise ? out.sigma_dn_s[y] : nullptr;
    row.flags = out.flags[y];
    for (std::size_t f = 0; f < frames_.size(); ++f)
      rows_[2 * f + static_cast<std::size_t>(r)] = frames_[f]->frame.dn[y];
  }
  merge_columns(work);
  if (rest == 0) return;

  for (std::size_t i = 0; i < rows_.size(); ++i) {
    std::uint16_t* tail = tail_.data() + i * kLanes;
    for (int c = 0; c < kLanes; ++c) tail[c] = rows_[i][whole + std::min(c, rest - 1)];
    rows_[i] = tail;
  }
  std::array<std::array<float, kLanes>, 2> phi, sigma;
  std::array<std::array<std::uint8_t, kLanes>, 2> flags;
  std::array<RowWork, 2> wanted = work.out;
  work.n = kLanes;
  for (std::size_t r = 0; r < 2; ++r) {
    work.out[r].phi = phi[r].data();
    if (options_.noise) work.out[r].sigma = sigma[r].data();
    work.out[r].flags = flags[r].data();
  }
  merge_columns(work);
  for (std::size_t r = 0; r < 2; ++r) {
    std::copy_n(phi[r].data(), rest, wanted[r].phi + whole);
    if (options_.noise) std::copy_n(sigma[r].data(), rest, wanted[r].sigma + whole);
    std::copy_n(flags[r].data(), rest, wanted[r].flags + whole);
  }
}

void CellMerger::merge_full_noise(int top, int bottom, MergedMosaic& out) {
  const SensorNoise& noise = *options_.noise;
  const int width = out.flags.cols;
  std::vector<const RawExposure*> used;
  const auto merge_pixel = [&](int r, int c) {
    const double k = noise.dn_per_electron[static_cast<std::size_t>(bayer_colour(pattern_, r, c))];
    const double black = options_.black_dn[static_cast<std::size_t>(2 * (r & 1) + (c & 1))];
    double phi = out.mosaic.values(r, c), sigma = 0;
    for (int i = 0; i < kFullNoiseIterations; ++i) {
      double weights = 0, sum = 0;
      for (const RawExposure* f : used) {
        const double scale_s = f->scale_s();
        const double electronic = noise.read_noise_e * noise.read_noise_e * f->gain * f->gain +
                                  noise.adc_noise * noise.adc_noise;
        const double variance =
            std::max(phi * scale_s * f->gain * k + electronic * k * k, kSmallestVariance);
        weights += scale_s * scale_s / variance;
        sum += scale_s * (f->frame.dn(r, c) - black) / variance;
      }
      phi = sum / weights;
      sigma = 1 / std::sqrt(weights);
    }
    out.mosaic.values(r, c) = static_cast<float>(phi);
    out.sigma_dn_s(r, c) = static_cast<float>(sigma);
    std::uint8_t& flags = out.flags(r, c);
    flags &= static_cast<std::uint8_t>(~kUnderexposed);
    if (phi < kDetectionLimit * sigma) flags |= kUnderexposed;
  };
  for (int left = 0; left < width; left += 2) {
    const int right = std::min(left + 1, width - 1);
    used.clear();
    for (const RawExposure* f : frames_) {
      const cv::Mat1w& dn = f->frame.dn;
      const int highest =
          std::max({dn(top, left), dn(top, right), dn(bottom, left), dn(bottom, right)});
      if (used.empty() || highest < options_.saturation_dn) used.push_back(f);
    }
    for (int r = top; r <= bottom; ++r)
      for (int c = left; c <= right; ++c) merge_pixel(r, c);
  }
}

}  // namespace wheatstone
