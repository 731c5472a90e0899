#include "rendering/metrics/hdrvdp3/cosine_transform.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace wheatstone {
namespace {

constexpr int kStripRows = 32;  // transformed together, so that tables are set up rarely

/// cos and sin of pi k / 2n for k = 0..n/2.
struct HalfSampleShift {
  std::vector<double> cosine, sine;

  explicit HalfSampleShift(int n) {
    for (int k = 0; k <= n / 2; ++k) {
      cosine.push_back(std::cos(std::numbers::pi * k / (2.0 * n)));
      sine.push_back(std::sin(std::numbers::pi * k / (2.0 * n)));
    }
  }
};

/// One row from n samples, even ones first and odd ones after them backwards, whose DFT (packed as
/// OpenCV does: Re 0, Re 1, Im 1, ...) is the cosine transform up to a half-sample shift.
void fold(const double* in, double* out, int n) {
  for (int i = 0; 2 * i < n; ++i) out[i] = in[2 * i];
  for (int i = 0; 2 * i + 1 < n; ++i) out[n - 1 - i] = in[2 * i + 1];
}
void unfold(const double* in, double* out, int n) {
  for (int i = 0; 2 * i < n; ++i) out[2 * i] = in[i];
  for (int i = 0; 2 * i + 1 < n; ++i) out[2 * i + 1] = in[n - 1 - i];
}

void dft_to_cosine(const double* dft, double* out, int n, const HalfSampleShift& shift) {
  out[0] = dft[0];
  for (int k = 1; 2 * k < n; ++k) {
    const double re = dft[2 * k - 1], im = dft[2 * k];
    out[k] = shift.cosine[k] * re + shift.sine[k] * im;
    out[n - k] = shift.sine[k] * re - shift.cosine[k] * im;
  }
  if (n % 2 == 0) out[n / 2] = shift.cosine[n / 2] * dft[n - 1];
}

void cosine_to_dft(const double* in, double* dft, int n, const HalfSampleShift& shift) {
  dft[0] = in[0];
  for (int k = 1; 2 * k < n; ++k) {
    dft[2 * k - 1] = shift.cosine[k] * in[k] + shift.sine[k] * in[n - k];
    dft[2 * k] = shift.sine[k] * in[k] - shift.cosine[k] * in[n - k];
  }
  if (n % 2 == 0) dft[n - 1] = in[n / 2] / shift.cosine[n / 2];
}

enum class Direction { kForward, kInverse };

/// Transforms the rows and transposes, so that a second call does the columns.
void transform_rows_transposed(const cv::Mat1d& in, cv::Mat1d& out, Direction direction) {
  const int n = in.cols;
  const HalfSampleShift shift(n);
  out.create(n, in.rows);
  tbb::parallel_for(0, (in.rows + kStripRows - 1) / kStripRows, [&](int strip) {
    const cv::Range rows(strip * kStripRows, std::min(in.rows, (strip + 1) * kStripRows));
    cv::Mat1d before(rows.size(), n), after(rows.size(), n);
    for (int r = 0; r < rows.size(); ++r)
      if (direction == Direction::kForward)
        fold(in[rows.start + r], before[r], n);
      else
        cosine_to_dft(in[rows.start + r], before[r], n, shift);
    cv::dft(before, after,
            direction == Direction::kForward
                ? int{cv::DFT_ROWS}
                : cv::DFT_ROWS | cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
    for (int r = 0; r < rows.size(); ++r)
      if (direction == Direction::kForward)
        dft_to_cosine(after[r], before[r], n, shift);
      else
        unfold(after[r], before[r], n);
    cv::transpose(before, out.colRange(rows));
  });
}

void transform(cv::Mat1d& image, Direction direction) {
  cv::Mat1d transposed;
  transform_rows_transposed(image, transposed, direction);
  transform_rows_transposed(transposed, image, direction);
}

}  // namespace

void cosine_transform(cv::Mat1d& image) {
  transform(image, Direction::kForward);
}

void inverse_cosine_transform(cv::Mat1d& spectrum) {
  transform(spectrum, Direction::kInverse);
}

}  // namespace wheatstone
