#include "capture/deglare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/toml_file.h"

namespace wheatstone {
namespace {

/// |frequency| of bin k of n, cycles per pixel.
double frequency(int k, int n) {
  return n < 2 ? 0 : std::min(k, n - k) * 0.5 / (n / 2);
}

double lobe(double rho, double a, double b, double c) {
  return a * std::exp(-std::pow((rho - b) / c, 2));
}

double passed(const GlareMtf& mtf, double rho) {
  return lobe(rho, mtf.a1, mtf.b1, mtf.c1) + lobe(rho, mtf.a2, mtf.b2, mtf.c2);
}

/// Half cycles per pixel.
double rho_of(int r, int c, cv::Size plane) {
  return std::hypot(frequency(r, plane.height), frequency(c, plane.width)) / 2;
}

/// A lens passes even light as a whole, and dividing by less than a twentieth leaves noise alone.
void require_usable(const GlareMtf& mtf, cv::Size plane) {
  if (!(std::abs(passed(mtf, 0) - 1) <= 1e-3))
    throw ArgumentError(fmt::format("the glare MTF is {:.4g} at rho = 0", passed(mtf, 0)),
                        "scale a1 and a2 so that it is 1 there");
  for (int r = 0; r <= plane.height / 2; ++r)
    for (int c = 0; c <= plane.width / 2; ++c) {
      const double rho = rho_of(r, c, plane);
      if (!(passed(mtf, rho) >= 0.05) || !std::isfinite(passed(mtf, rho)))
        throw ArgumentError(
            fmt::format("the glare MTF is {:.4g} at rho = {:.4g}", passed(mtf, rho), rho),
            "give parameters that keep it at 0.05 or above for all frequencies of the image");
    }
}

cv::Mat1d without_glare(const cv::Mat1d& plane, const GlareMtf& mtf) {
  cv::Mat2d spectrum;
  cv::dft(plane, spectrum, cv::DFT_COMPLEX_OUTPUT);
  for (int r = 0; r < plane.rows; ++r)
    for (int c = 0; c < plane.cols; ++c) spectrum(r, c) /= passed(mtf, rho_of(r, c, plane.size()));
  cv::dft(spectrum, spectrum, cv::DFT_INVERSE | cv::DFT_SCALE);
  cv::Mat1d out(plane.size());
  for (int r = 0; r < plane.rows; ++r)
    for (int c = 0; c < plane.cols; ++c)
      out(r, c) = std::hypot(spectrum(r, c)[0], spectrum(r, c)[1]);
  return out;
}

}  // namespace

LinearMosaic remove_glare(const LinearMosaic& mosaic, const GlareMtf& mtf) {
  const cv::Mat1f& in = mosaic.values;
  if (in.rows < 2 || in.cols < 2)
    throw ArgumentError("the mosaic has less than one 2 x 2 cell", "give a larger one");
  LinearMosaic out{cv::Mat1f(in.size()), mosaic.pattern};
  for (int first_row = 0; first_row < 2; ++first_row)
    for (int first_column = 0; first_column < 2; ++first_column) {
      cv::Mat1d plane((in.rows - first_row + 1) / 2, (in.cols - first_column + 1) / 2);
      for (int r = 0; r < plane.rows; ++r)
        for (int c = 0; c < plane.cols; ++c)
          plane(r, c) = in(2 * r + first_row, 2 * c + first_column);
      require_usable(mtf, plane.size());
      plane = without_glare(plane, mtf);
      for (int r = 0; r < plane.rows; ++r)
        for (int c = 0; c < plane.cols; ++c)
          out.values(2 * r + first_row, 2 * c + first_column) = static_cast<float>(plane(r, c));
    }
  return out;
}

GlareMtf read_glare_mtf(const std::filesystem::path& file) {
  constexpr const char* kSchema = "wheatstone-glare/1";
  constexpr double kLargest = 1e6;
  const TomlTable t = TomlTable::read(file, "docs/hdr_merge.md");
  if (t.text("schema") != kSchema) t.fail("schema", std::string("is not \"") + kSchema + "\"");
  t.text("lens");
  GlareMtf mtf;
  mtf.a1 = t.number("a1", -kLargest, kLargest);
  mtf.b1 = t.number("b1", -kLargest, kLargest);
  mtf.c1 = t.number("c1", 1e-6, kLargest);
  mtf.a2 = t.number("a2", -kLargest, kLargest);
  mtf.b2 = t.number("b2", -kLargest, kLargest);
  mtf.c2 = t.number("c2", 1e-6, kLargest);
  t.finish();
  return mtf;
}

}  // namespace wheatstone
