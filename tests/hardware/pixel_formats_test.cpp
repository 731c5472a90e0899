#include "hardware/video/pixel_formats.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

namespace wheatstone {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(PixelFormats, BytesStayAsTheyAreAndPaddingIsLeftOut) {
  const Bytes bytes = {1, 2, 3, 0xa5, 4, 5, 6};  // the last line is not padded
  for (const char* format : {"GREY", "RGGB", "GRBG", "GBRG", "BA81"}) {
    const auto pixels = decode({format, 3, 2, 4}, bytes);
    ASSERT_TRUE(pixels);
    EXPECT_EQ(cv::norm(*pixels, cv::Mat1b({2, 3}, {1, 2, 3, 4, 5, 6}), cv::NORM_INF), 0);
  }
}

TEST(PixelFormats, WordsAreLittleEndianAndBitsBeyondTheirDepthAreDropped) {
  const Bytes bytes = {0x34, 0x12, 0xff, 0xff};
  const auto expect = [&](const char* format, std::uint16_t a, std::uint16_t b) {
    const auto pixels = decode({format, 2, 1, 4}, bytes);
    ASSERT_TRUE(pixels);
    EXPECT_EQ(pixels->at<std::uint16_t>(0, 0), a) << format;
    EXPECT_EQ(pixels->at<std::uint16_t>(0, 1), b) << format;
  };
  expect("Y16 ", 0x1234, 0xffff);
  expect("Y12 ", 0x234, 0xfff);
  for (const char* format : {"Y10 ", "RG10", "BA10", "GB10", "BG10"}) expect(format, 0x234, 0x3ff);
}

TEST(PixelFormats, FourPixelsOfTenBitsArePackedInFiveBytes) {
  // 0x3ff, 0x000, 0x201, 0x156: high bytes, then the low pairs from the lowest bits up.
  const Bytes bytes = {0xff, 0x00, 0x80, 0x55, 0b10'01'00'11};
  for (const char* format : {"Y10P", "pRAA", "pgAA", "pGAA", "pBAA"}) {
    const auto pixels = decode({format, 4, 1, 5}, bytes);
    ASSERT_TRUE(pixels);
    EXPECT_EQ(cv::norm(*pixels, cv::Mat1w({1, 4}, {0x3ff, 0x000, 0x201, 0x156}), cv::NORM_INF), 0);
  }
  EXPECT_EQ(least_bytes_per_line("Y10P", 5), 10U);
}

TEST(PixelFormats, YuyvIsBt601InItsRange) {
  const auto rgb = [](Bytes bytes, bool full_range) {
    return decode({"YUYV", 2, 1, 4, full_range}, bytes)->at<cv::Vec3b>(0, 1);
  };
  EXPECT_EQ(rgb({0, 128, 235, 128}, false), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(rgb({0, 128, 16, 128}, false), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(rgb({0, 128, 255, 128}, true), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(rgb({0, 90, 81, 240}, false), cv::Vec3b(254, 0, 0));  // red of BT.601's bars
}

TEST(PixelFormats, TooFewBytesAreNoPicture) {
  for (const char* format : {"GREY", "Y16 ", "Y10P", "YUYV"}) {
    const std::size_t line = least_bytes_per_line(format, 8) + 3;
    const std::size_t whole = line + least_bytes_per_line(format, 8);
    EXPECT_TRUE(decode({format, 8, 2, line}, Bytes(whole))) << format;
    EXPECT_FALSE(decode({format, 8, 2, line}, Bytes(whole - 1))) << format;
    EXPECT_FALSE(decode({format, 8, 2, line}, {})) << format;
  }
}

TEST(PixelFormats, JpegIsTakenWholeAndOfItsSizeOnly) {
  const cv::Mat3b colour(16, 24, cv::Vec3b(20, 60, 200));  // B, G, R
  Bytes jpeg;
  cv::imencode(".jpg", colour, jpeg);
  const auto pixels = decode({"MJPG", 24, 16, 0}, jpeg);
  ASSERT_TRUE(pixels);
  EXPECT_LE(cv::norm(pixels->at<cv::Vec3b>(8, 8), cv::Vec3b(200, 60, 20), cv::NORM_INF), 4);

  EXPECT_FALSE(decode({"MJPG", 16, 24, 0}, jpeg)) << "another size";
  Bytes padded = jpeg;
  padded.resize(padded.size() + 100);
  EXPECT_TRUE(decode({"MJPG", 24, 16, 0}, padded));
  for (const std::size_t cut : {jpeg.size() - 1, jpeg.size() / 2, std::size_t{3}})
    EXPECT_FALSE(decode({"MJPG", 24, 16, 0}, std::span(jpeg).first(cut))) << cut;
  Bytes progressive;
  cv::imencode(".jpg", colour, progressive, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  EXPECT_FALSE(decode({"MJPG", 24, 16, 0}, progressive)) << "no baseline JPEG";
}

TEST(PixelFormats, KnowsWhatItKnows) {
  EXPECT_TRUE(is_known_format("MJPG"));
  for (const char* format : {"", "GREY ", "grey", "H264", "Y16"})
    EXPECT_FALSE(is_known_format(format));
}

}  // namespace
}  // namespace wheatstone
