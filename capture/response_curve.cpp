#include "capture/response_curve.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr int kPixelsAcross = 60;  // of the grid that the curve is fitted to
constexpr int kFewestUseful = 256;

/// A hat over the codes: the ends of the curve are steep and clipped.
double weight(int code) {
  return std::min(code, 255 - code) / 127.0;
}

void check(const EncodedStack& stack) {
  if (stack.frames.size() < 2 || stack.frames.size() != stack.exposure_s.size())
    throw ArgumentError("a stack needs at least two frames, each with its time", "add some");
  for (std::size_t i = 0; i < stack.frames.size(); ++i) {
    const std::string name = "frame " + std::to_string(i);
    if (stack.frames[i].empty() || stack.frames[i].size() != stack.frames[0].size())
      throw ArgumentError(name + " has another size than the first", "register the frames");
    if (!(stack.exposure_s[i] > 0) || !std::isfinite(stack.exposure_s[i]))
      throw ArgumentError(name + " has no exposure time above 0", "give it in seconds");
  }
  const auto [shortest, longest] =
      std::minmax_element(stack.exposure_s.begin(), stack.exposure_s.end());
  if (*shortest == *longest)
    throw ArgumentError("all frames have the same exposure time", "give the true times");
}

}  // namespace

ResponseCurve fit_response_curve(const EncodedStack& stack, double smoothness) {
  check(stack);
  // Normal equations of the curve alone: the light of each pixel is eliminated from its own few.
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(256, 256);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(256);
  const cv::Size size = stack.frames[0].size();
  const int step = std::max(1, std::max(size.width, size.height) / kPixelsAcross);
  int useful = 0;
  for (int r = step / 2; r < size.height; r += step)
    for (int c = step / 2; c < size.width; c += step) {
      double total = 0, log_time = 0;
      int seen = 0;
      for (std::size_t i = 0; i < stack.frames.size(); ++i) {
        const double w2 = std::pow(weight(stack.frames[i](r, c)), 2);
        total += w2;
        log_time += w2 * std::log(stack.exposure_s[i]);
        seen += w2 > 0;
      }
      if (seen < 2) continue;
      ++useful;
      for (std::size_t i = 0; i < stack.frames.size(); ++i) {
        const int z = stack.frames[i](r, c);
        const double w2 = std::pow(weight(z), 2);
        A(z, z) += w2;
        b(z) += w2 * (std::log(stack.exposure_s[i]) - log_time / total);
        for (const cv::Mat1b& other : stack.frames)
          A(z, other(r, c)) -= w2 * std::pow(weight(other(r, c)), 2) / total;
      }
    }
  if (useful < kFewestUseful)
    throw ArgumentError("only " + std::to_string(useful) + " pixels are well exposed in two frames",
                        "add frames, or larger ones");
  for (int z = 1; z < 255; ++z) {
    const double s = smoothness * std::pow(weight(z), 2);
    const double bend[3] = {1, -2, 1};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) A(z - 1 + i, z - 1 + j) += s * bend[i] * bend[j];
  }
  A(128, 128) += 1;
  const Eigen::VectorXd g = A.ldlt().solve(b);
  ResponseCurve curve;
  for (int z = 0; z < 256; ++z) curve[static_cast<std::size_t>(z)] = g[z] - g[128];
  return curve;
}

cv::Mat1f merge_encoded(const EncodedStack& stack, const ResponseCurve& curve) {
  check(stack);
  const auto [shortest, longest] =
      std::minmax_element(stack.exposure_s.begin(), stack.exposure_s.end());
  const cv::Size size = stack.frames[0].size();
  cv::Mat1f out(size);
  for (int r = 0; r < size.height; ++r)
    for (int c = 0; c < size.width; ++c) {
      double sum = 0, total = 0;
      for (std::size_t i = 0; i < stack.frames.size(); ++i) {
        const int z = stack.frames[i](r, c);
        sum += weight(z) * (curve[static_cast<std::size_t>(z)] - std::log(stack.exposure_s[i]));
        total += weight(z);
      }
      if (total == 0)
        sum = stack.frames[0](r, c) == 255 ? curve[255] - std::log(*shortest)
                                           : curve[0] - std::log(*longest);
      out(r, c) = static_cast<float>(std::exp(total > 0 ? sum / total : sum));
    }
  return out;
}

}  // namespace wheatstone
