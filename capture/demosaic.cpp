#include "capture/demosaic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

// A pixel depends on samples at most this far away, so tiles that overlap by it are independent.
constexpr int kReach_px = 8;
constexpr int kTileWidth_px = 512, kTileHeight_px = 256;  // the rows in work stay in cache
constexpr int kHalfWidth = kTileWidth_px / 2 + kReach_px;

// Each row of a mosaic alternates between green sites and sites of one other colour, here called
// chroma (red in one row, blue in the next). Everything is computed on half-wide rows, one value
// per site of a kind, so that all inner loops are dense. With p the column of the first chroma
// site:
//   chroma site i stands at column 2i + p, green site j at column 2j + 1 - p;
//   the greens beside chroma i are i - 1 + p and i + p; the chromas beside green j, j - p, j + 1 -
//   p; above and below a site stands one of the other kind with the same index.

/// The last rows of one quantity, with a margin of one value on either side.
class HalfRows {
 public:
  float* row(int r) { return values_.data() + (static_cast<std::size_t>(r) % kKept) * kStride + 1; }

 private:
  // Rows are read up to kReach_px behind and ahead of the newest one; mirrored ones are nearer.
  static constexpr std::size_t kKept = 16, kStride = kHalfWidth + 2;
  std::vector<float> values_ = std::vector<float>(kKept * kStride);
};

int mirrored(int i, int count) {
  return cv::borderInterpolate(i, count, cv::BORDER_REFLECT_101);
}

/// a where `first` is 1, b where it is 0: without a branch, so that loops become vector code.
float choose(float first, float a, float b) {
  return first * a + (1.0F - first) * b;
}

/// Demosaics tiles, one after the other, each as if it were a whole picture.
class Demosaicer {
 public:
  Demosaicer(BayerPattern pattern, bool refine) : pattern_(pattern), refine_(refine) {}

  /// Writes the rows of `samples` from `top` on, columns from `left` on, to `out`. `first_row` is
  /// that of the samples in the mosaic; they begin in an even column.
  void run(const cv::Mat1f& samples, int first_row, int top, int left, cv::Mat3f out) {
    samples_ = samples;
    first_row_ = first_row;
    // Each stage runs as far ahead of the output as the later ones look down.
    for (int r = -kReach_px; r < top + out.rows; ++r) {
      stage(&Demosaicer::split, r + 8);
      stage(&Demosaicer::filter, r + 6);
      stage(&Demosaicer::decide, r + 4);
      stage(&Demosaicer::fill_greens, r + 3);
      stage(&Demosaicer::fill_chromas, r + 2);
      if (refine_) stage(&Demosaicer::refill_greens, r + 1);
      if (r >= top) write(r, left, out[r - top], out.cols);
    }
  }

 private:
  int width() const { return samples_.cols; }
  int height() const { return samples_.rows; }
  int half_width() const { return (width() + 1) / 2; }
  int colour(int r, int c) const { return bayer_colour(pattern_, first_row_ + r, c); }
  int chroma_parity(int r) const { return colour(r, 0) == 1 ? 1 : 0; }
  int sites(int parity) const { return (width() - parity + 1) / 2; }
  int above(int r) const { return mirrored(r - 1, height()); }
  int below(int r) const { return mirrored(r + 1, height()); }

  void stage(void (Demosaicer::*work)(int), int r) {
    if (r >= 0 && r < height()) (this->*work)(r);
  }

  /// Mirrors the row of sites at columns 2i + parity into its margins.
  void mirror_margins(float* row, int parity) const {
    const int n = sites(parity);
    row[-1] = row[mirrored(parity - 2, width()) / 2];
    row[n] = row[mirrored(2 * n + parity, width()) / 2];
  }

  void split(int r) {
    const float* in = samples_[r];
    const int p = chroma_parity(r), chromas = sites(p), greens = sites(1 - p);
    float *x = chroma_.row(r), *g = green_.row(r);
    for (int i = 0; i < chromas; ++i) x[i] = in[2 * i + p];
    for (int j = 0; j < greens; ++j) g[j] = in[2 * j + 1 - p];
    mirror_margins(x, p);
    mirror_margins(g, 1 - p);
  }

  /// Colour differences chroma - green along either direction, and their gradients (eq. 1 to 7).
  void filter(int r) {
    const int p = chroma_parity(r), n = sites(p);
    const float* x = chroma_.row(r);
    const float* x_up = chroma_.row(mirrored(r - 2, height()));
    const float* x_down = chroma_.row(mirrored(r + 2, height()));
    const float* g = green_.row(r) - 1 + p;
    const float *g_up = green_.row(above(r)), *g_down = green_.row(below(r));
    float* __restrict h = difference_h_.row(r);
    float* __restrict v = difference_v_.row(r);
    for (int i = 0; i < n; ++i) {
      h[i] = 0.5F * (x[i] - (g[i] + g[i + 1])) + 0.25F * (x[i - 1] + x[i + 1]);
      v[i] = 0.5F * (x[i] - (g_up[i] + g_down[i])) + 0.25F * (x_up[i] + x_down[i]);
    }
    mirror_margins(h, p);
    float* __restrict gradient = gradient_h_.row(r);
    for (int i = 0; i < n; ++i) gradient[i] = std::abs(h[i] - h[i + 1]);
    gradient[-1] = gradient[n] = 0;
    float* __restrict pair = gradient_h_pair_.row(r);
    for (int i = 0; i < n; ++i) pair[i] = gradient[i] + gradient[i - 1];
    // The vertical gradient looks two rows down.
    if (r >= 2) filter_gradient_v(r - 2);
    if (r == height() - 1)
      for (int last = std::max(0, r - 1); last <= r; ++last) filter_gradient_v(last);
  }

  void filter_gradient_v(int r) {
    const int n = sites(chroma_parity(r));
    const float *v = difference_v_.row(r), *v_down = difference_v_.row(mirrored(r + 2, height()));
    float* __restrict gradient = gradient_v_.row(r);
    for (int i = 0; i < n; ++i) gradient[i] = std::abs(v[i] - v_down[i]);
    gradient[-1] = gradient[n] = 0;
  }

  /// The direction in which the colour difference varies less (section III). Gradients at green
  /// sites are 0, so the 5x5 sums have ten terms; outside the picture they count as 0.
  void decide(int r) {
    const int p = chroma_parity(r), n = sites(p);
    const auto at = [&](HalfRows& rows, int row) -> const float* {
      return row >= 0 && row < height() ? rows.row(row) : zero_.data() + 1;
    };
    const float *h0 = gradient_h_pair_.row(r), *h_up2 = at(gradient_h_pair_, r - 2),
                *h_down2 = at(gradient_h_pair_, r + 2), *h_up = at(gradient_h_, r - 1) + p - 1,
                *h_down = at(gradient_h_, r + 1) + p - 1;
    const float *v0 = gradient_v_.row(r), *v_up = at(gradient_v_, r - 1) + p - 1,
                *v_up2 = at(gradient_v_, r - 2);
    const float *difference_h = difference_h_.row(r), *difference_v = difference_v_.row(r);
    float* __restrict horizontal = horizontal_.row(r);
    float* __restrict k = difference_.row(r);
    for (int i = 0; i < n; ++i) {
      const float across = (h_up2[i] + h_down2[i]) + (h_up[i] + h_down[i]) + 3.0F * h0[i];
      const float down = (v0[i - 1] + v0[i + 1] + v_up2[i - 1] + v_up2[i + 1]) +
                         (v_up[i] + v_up[i + 1]) + 3.0F * (v0[i] + v_up2[i]);
      horizontal[i] = down >= across ? 1.0F : 0.0F;
    }
    for (int i = 0; i < n; ++i) k[i] = choose(horizontal[i], difference_h[i], difference_v[i]);
    mirror_margins(k, p);
  }

  /// At green sites: the chroma of the own row and that of the rows above and below, minus green.
  void fill_greens_from(HalfRows& difference, HalfRows& own_row, HalfRows& other_row,
                        HalfRows& other_minus_own, int r) {
    const int p = chroma_parity(r), n = sites(1 - p);
    const float* k = difference.row(r) - p;
    const float *k_up = difference.row(above(r)), *k_down = difference.row(below(r));
    float* __restrict own = own_row.row(r);
    float* __restrict other = other_row.row(r);
    float* __restrict change = other_minus_own.row(r);
    for (int j = 0; j < n; ++j) {
      own[j] = 0.5F * (k[j] + k[j + 1]);
      other[j] = 0.5F * (k_up[j] + k_down[j]);
      change[j] = other[j] - own[j];
    }
    mirror_margins(own, 1 - p);
    mirror_margins(change, 1 - p);
  }
  void fill_greens(int r) { fill_greens_from(difference_, own_, other_, change_, r); }
  void refill_greens(int r) {
    fill_greens_from(refined_, refined_own_, refined_other_, refined_change_, r);
  }

  /// At chroma sites, along the decided direction: the missing chroma minus the measured one, and
  /// green again as the mean of three differences (section IV).
  void fill_chromas(int r) {
    const int p = chroma_parity(r), n = sites(p);
    const float *horizontal = horizontal_.row(r), *k = difference_.row(r);
    const float *change = change_.row(r) - 1 + p, *own = own_.row(r) - 1 + p;
    const float *change_up = change_.row(above(r)), *change_down = change_.row(below(r));
    const float *other_up = other_.row(above(r)), *other_down = other_.row(below(r));
    float* __restrict missing = missing_.row(r);
    float* __restrict refined = refined_.row(r);
    for (int i = 0; i < n; ++i) {
      // Above and below, the own row's colour is the one missing here: the sign turns.
      const float across = change[i] + change[i + 1], down = -(change_up[i] + change_down[i]);
      missing[i] = 0.5F * choose(horizontal[i], across, down);
    }
    for (int i = 0; i < n; ++i) {
      const float across = own[i] + own[i + 1], down = other_up[i] + other_down[i];
      refined[i] = (k[i] + choose(horizontal[i], across, down)) * (1.0F / 3.0F);
    }
    mirror_margins(refined, p);
  }

  void write(int r, int left, cv::Vec3f* out, int count) {
    const int p = chroma_parity(r), n = half_width(), own_colour = colour(r, p);
    const float *x = chroma_.row(r), *g = green_.row(r);
    const float* k = (refine_ ? refined_ : difference_).row(r);
    const float* missing = refine_ ? refine_missing(r) : missing_.row(r);
    const float* own = (refine_ ? refined_own_ : own_).row(r);
    const float* other = (refine_ ? refined_other_ : other_).row(r);
    // In odd widths one kind has a site less; the margin takes the value too many.
    float* __restrict at_chroma = colours_at_chroma_[own_colour].data();
    float* __restrict at_green = colours_at_green_[own_colour].data();
    for (int i = 0; i < n; ++i) at_chroma[i] = x[i];
    for (int i = 0; i < n; ++i) at_green[i] = g[i] + own[i];
    at_chroma = colours_at_chroma_[1].data();
    at_green = colours_at_green_[1].data();
    for (int i = 0; i < n; ++i) at_chroma[i] = x[i] - k[i];
    for (int i = 0; i < n; ++i) at_green[i] = g[i];
    at_chroma = colours_at_chroma_[2 - own_colour].data();
    at_green = colours_at_green_[2 - own_colour].data();
    for (int i = 0; i < n; ++i) at_chroma[i] = x[i] + missing[i];
    for (int i = 0; i < n; ++i) at_green[i] = g[i] + other[i];
    if (p == 0)
      interleave(colours_at_chroma_, colours_at_green_, left / 2, out, count);
    else
      interleave(colours_at_green_, colours_at_chroma_, left / 2, out, count);
  }

  /// The refined missing chroma minus the measured one: a mean of three differences.
  const float* refine_missing(int r) {
    const int p = chroma_parity(r), n = sites(p);
    const float *horizontal = horizontal_.row(r), *missing = missing_.row(r);
    const float* change = refined_change_.row(r) - 1 + p;
    const float *up = refined_change_.row(above(r)), *down = refined_change_.row(below(r));
    float* __restrict mean = mean_.data();
    for (int i = 0; i < n; ++i) {
      const float across = change[i] + change[i + 1], along = -(up[i] + down[i]);
      mean[i] = (missing[i] + choose(horizontal[i], across, along)) * (1.0F / 3.0F);
    }
    return mean;
  }

  using Colours = std::array<std::vector<float>, 3>;

  /// Pixels from the values at even and at odd columns, `first` of each left out.
  static void interleave(const Colours& even, const Colours& odd, int first, cv::Vec3f* out,
                         int count) {
    int i = first;
    for (; count >= 8; i += 4, count -= 8, out += 8) {
      std::array<cv::v_float32x4, 3> low, high;
      for (std::size_t k = 0; k < 3; ++k)
        cv::v_zip(cv::v_load(&even[k][i]), cv::v_load(&odd[k][i]), low[k], high[k]);
      cv::v_store_interleave(out->val, low[0], low[1], low[2]);
      cv::v_store_interleave(out[4].val, high[0], high[1], high[2]);
    }
    for (int c = 0; c < count; ++c)
      for (std::size_t k = 0; k < 3; ++k)
        out[c][static_cast<int>(k)] = (c % 2 == 0 ? even : odd)[k][i + c / 2];
  }

  BayerPattern pattern_;
  bool refine_;
  cv::Mat1f samples_;
  int first_row_ = 0;
  std::vector<float> zero_ = std::vector<float>(kHalfWidth + 2), mean_ = zero_;
  Colours colours_at_chroma_ = {zero_, zero_, zero_}, colours_at_green_ = colours_at_chroma_;
  // At chroma sites.
  HalfRows chroma_, difference_h_, difference_v_;
  HalfRows gradient_h_, gradient_h_pair_, gradient_v_;
  HalfRows horizontal_;            // 1 where the decision is horizontal, else 0
  HalfRows difference_, refined_;  // chroma - green
  HalfRows missing_;               // missing - measured chroma
  // At green sites.
  HalfRows green_;
  HalfRows own_, other_, change_;
  HalfRows refined_own_, refined_other_, refined_change_;
};

}  // namespace

void demosaic_rows(const LinearMosaic& mosaic, cv::Range rows, cv::Mat3f& out, bool refine) {
  const cv::Size size = mosaic.values.size();
  if (size.width < 2 || size.height < 2)
    throw ArgumentError("a mosaic of " + std::to_string(size.width) + " x " +
                            std::to_string(size.height) + " px does not hold all colours",
                        "give at least one 2 x 2 cell");
  WHEATSTONE_CHECK(rows.start, >=, 0);
  WHEATSTONE_CHECK(rows.end, <=, size.height);
  out.create(rows.size(), size.width);
  const int across = (size.width + kTileWidth_px - 1) / kTileWidth_px;
  const int down = (rows.size() + kTileHeight_px - 1) / kTileHeight_px;
  const auto demosaic_tiles = [&](const cv::Range& tiles) {
    Demosaicer demosaicer(mosaic.pattern, refine);
    for (int t = tiles.start; t < tiles.end; ++t) {
      const cv::Rect wanted =
          cv::Rect(t % across * kTileWidth_px, rows.start + t / across * kTileHeight_px,
                   kTileWidth_px, kTileHeight_px) &
          cv::Rect(0, rows.start, size.width, rows.size());
      const cv::Rect seen = cv::Rect(wanted.x - kReach_px, wanted.y - kReach_px,
                                     wanted.width + 2 * kReach_px, wanted.height + 2 * kReach_px) &
                            cv::Rect({0, 0}, size);
      demosaicer.run(mosaic.values(seen), seen.y, wanted.y - seen.y, wanted.x - seen.x,
                     out(wanted - cv::Point(0, rows.start)));
    }
  };
  // Few stripes, because each needs working memory of its own.
  cv::parallel_for_(cv::Range(0, across * down), demosaic_tiles, 4.0 * cv::getNumThreads());
}

cv::Mat3f demosaic(const LinearMosaic& mosaic, bool refine) {
  cv::Mat3f out;
  demosaic_rows(mosaic, {0, mosaic.values.rows}, out, refine);
  return out;
}

}  // namespace wheatstone
