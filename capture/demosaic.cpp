#include "capture/demosaic.h"

#include <array>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {

cv::Mat3f demosaic_bilinear(const LinearMosaic& mosaic) {
  const cv::Size size = mosaic.values.size();
  if (size.width < 2 || size.height < 2)
    throw ArgumentError("a mosaic of " + std::to_string(size.width) + " x " +
                            std::to_string(size.height) + " px does not hold all colours",
                        "give at least one 2 x 2 cell");
  // On its own grid each kernel only reaches the samples that bilinear interpolation uses.
  const cv::Matx33f square(1, 2, 1, 2, 4, 2, 1, 2, 1), diamond(0, 1, 0, 1, 4, 1, 0, 1, 0);
  std::array<cv::Mat1f, 3> planes;
  for (int colour = 0; colour < 3; ++colour) {
    cv::Mat1f samples = cv::Mat1f::zeros(size), valid = cv::Mat1f::zeros(size);
    for (int r = 0; r < size.height; ++r)
      for (int c = 0; c < size.width; ++c)
        if (bayer_colour(mosaic.pattern, r, c) == colour) {
          samples(r, c) = mosaic.values(r, c);
          valid(r, c) = 1;
        }
    const cv::Matx33f& kernel = colour == 1 ? diamond : square;
    cv::Mat1f sum, weight;
    cv::filter2D(samples, sum, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_CONSTANT);
    cv::filter2D(valid, weight, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_CONSTANT);
    cv::divide(sum, weight, planes[static_cast<std::size_t>(colour)]);
  }
  cv::Mat3f out;
  cv::merge(planes.data(), 3, out);
  return out;
}

}  // namespace wheatstone
