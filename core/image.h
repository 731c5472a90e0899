#pragma once
// Image types. The type says what a number in the image means; cv::Mat only stores it.
// Pixels follow OpenCV: row 0 at the top, the centre of the first pixel is (0, 0).

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

namespace wheatstone {

/// Linear light, BT.709 primaries, in cd/m^2: R = G = B = L is white of L cd/m^2.
/// Shape [height][width][rgb], channel order R, G, B (not OpenCV's B, G, R).
struct RgbImage {
  cv::Mat3f pixels;

  RgbImage() = default;
  RgbImage(int width, int height) : pixels(height, width, cv::Vec3f(0, 0, 0)) {}
  explicit RgbImage(cv::Mat3f p) : pixels(std::move(p)) {}
  int width() const { return pixels.cols; }
  int height() const { return pixels.rows; }
  bool empty() const { return pixels.empty(); }
};

/// One float per pixel; the name of the variable says which quantity and unit.
struct ScalarImage {
  cv::Mat1f pixels;

  ScalarImage() = default;
  ScalarImage(int width, int height, float value = 0) : pixels(height, width, value) {}
  explicit ScalarImage(cv::Mat1f p) : pixels(std::move(p)) {}
  int width() const { return pixels.cols; }
  int height() const { return pixels.rows; }
  bool empty() const { return pixels.empty(); }
};

/// Colours at positions (0,0), (0,1), (1,0), (1,1) of a mosaic's 2x2 cell (row, column).
enum class BayerPattern { kRggb, kBggr, kGrbg, kGbrg };
std::string to_string(BayerPattern);
BayerPattern bayer_pattern_from_string(const std::string&);  // throws ArgumentError

/// Colour index (0 = R, 1 = G, 2 = B) of the photosite at (row, column).
int bayer_colour(BayerPattern, int row, int column);

/// Digital numbers (DN) of a sensor behind a colour filter array, black level included.
struct MosaicImage {
  cv::Mat1w dn;
  BayerPattern pattern = BayerPattern::kRggb;
  int width() const { return dn.cols; }
  int height() const { return dn.rows; }
};

/// Linear sensor values behind a colour filter array after black level, exposure and gain are
/// divided out: DN/s at ISO 100. May be slightly negative before the final clip.
struct LinearMosaic {
  cv::Mat1f values;
  BayerPattern pattern = BayerPattern::kRggb;
};

/// Drive levels of one panel, 8-bit codes 0..255, not light. One channel for a projector
/// without a colour wheel (CV_8UC1), R, G, B for an LCD (CV_8UC3, order R, G, B).
struct DriveImage {
  cv::Mat codes;
  int width() const { return codes.cols; }
  int height() const { return codes.rows; }
};

/// Luminance of linear BT.709 light, with the weights the quality metrics use
/// (PU21: 0.212656, 0.715158, 0.072186).
inline constexpr std::array<double, 3> kLuminanceWeights = {0.212656, 0.715158, 0.072186};
ScalarImage luminance_cd_m2(const RgbImage&);

/// Throws ArgumentError, naming `what`, the count and the first place, if a pixel is NaN,
/// infinite or negative.
void require_valid_radiance(const RgbImage&, const std::string& what);

}  // namespace wheatstone
