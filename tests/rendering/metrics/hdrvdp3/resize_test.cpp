#include "rendering/metrics/hdrvdp3/resize.h"

#include <gtest/gtest.h>

#include "planes.h"

namespace wheatstone {
namespace {

TEST(ResizeBicubic, DoublingWeighsByTheKernel) {
  cv::Mat1d impulse = cv::Mat1d::zeros(1, 9);
  impulse(0, 4) = 1;
  const cv::Mat1d out = resize_bicubic(impulse, {18, 1});
  // Keys, a = -0.5, at distances 1.75, 1.25, 0.75, 0.25, 0.25, ... of the source.
  const double expected[] = {0,         -0.0234375, -0.0703125, 0.2265625,  0.8671875,
                             0.8671875, 0.2265625,  -0.0703125, -0.0234375, 0};
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(out(0, 4 + i), expected[i], 1e-15) << i;
}

TEST(ResizeBicubic, HalvingWidensTheKernel) {
  cv::Mat1d impulse = cv::Mat1d::zeros(16, 1);
  impulse(7, 0) = 1;  // 0.25 output pixels before the fourth output's centre, 7.5
  const cv::Mat1d out = resize_bicubic(impulse, {1, 8});
  const double expected[] = {0, 0, -0.0703125 / 2, 0.8671875 / 2, 0.2265625 / 2, -0.0234375 / 2, 0};
  // Output 3 has its centre at source 6.5, output 4 at 8.5: the impulse is 0.25 and 0.75 away.
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(out(i, 0), expected[i], 1e-15) << i;
}

TEST(ResizeBicubic, KeepsConstantsAndMirrors) {
  for (const cv::Size to : {cv::Size(20, 15), cv::Size(7, 5), cv::Size(81, 33), cv::Size(1, 1)}) {
    EXPECT_LT(largest_difference(resize_bicubic(cv::Mat1d(31, 40, 3.5), to), cv::Mat1d(to, 3.5)),
              1e-14)
        << to;
    const cv::Mat1d image = random_plane({40, 31});
    cv::Mat1d mirrored, back;
    cv::flip(image, mirrored, -1);
    cv::flip(resize_bicubic(mirrored, to), back, -1);
    EXPECT_LT(largest_difference(resize_bicubic(image, to), back), 1e-10) << to;
  }
}

TEST(ResizeBicubic, ContinuesAsTheMirrorImage) {
  const cv::Mat1d image = random_plane({10, 8});
  cv::Mat1d continued;
  cv::copyMakeBorder(image, continued, 8, 8, 10, 10, cv::BORDER_REFLECT);
  const cv::Mat1d whole = resize_bicubic(continued, {15, 12});  // half of 30x24
  EXPECT_LT(largest_difference(resize_bicubic(image, {5, 4}), whole(cv::Rect(5, 4, 5, 4))), 1e-12);
}

TEST(ResizeBicubic, SameSizeIsTheImage) {
  const cv::Mat1d image = random_plane({10, 8});
  EXPECT_EQ(largest_difference(resize_bicubic(image, image.size()), image), 0);
}

}  // namespace
}  // namespace wheatstone
