// A million damaged pictures: each decodes to a picture of the size asked for, or to none.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "hardware/video/pixel_formats.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

std::optional<cv::Mat> decode_text(const PixelLayout& layout, const std::string& bytes) {
  return decode(layout, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

TEST(PixelFormatsFuzz, DamagedPictures) {
  constexpr int kExecutions = 1'000'000, kOneJpegIn = 10;
  constexpr int kWidth = 16, kHeight = 8;
  ASSERT_TRUE(std::freopen("/dev/null", "w", stderr)) << "libjpeg says a line about each";
  constexpr std::array kRaw = {"GREY", "Y10 ", "Y16 ", "Y10P", "YUYV", "pRAA"};
  std::vector<std::uint8_t> encoded;
  cv::imencode(".jpg", cv::Mat3b(kHeight, kWidth, cv::Vec3b(20, 60, 200)), encoded);
  const std::string jpeg(encoded.begin(), encoded.end());
  RandomStream random(7, 3);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    PixelLayout layout{"MJPG", kWidth, kHeight, 0};
    std::string bytes = jpeg;
    if (i % kOneJpegIn) {
      layout.format = kRaw[static_cast<std::size_t>(i) % kRaw.size()];
      layout.bytes_per_line = least_bytes_per_line(layout.format, kWidth) + random.next() % 3;
      bytes.assign(layout.bytes_per_line * kHeight, '\x5a');
    }
    const auto pixels = decode_text(layout, mutated(std::move(bytes), random));
    if (!pixels) continue;
    ++taken;
    ASSERT_EQ(pixels->size(), cv::Size(kWidth, kHeight));
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace wheatstone
