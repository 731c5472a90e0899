#include "rendering/motion_quality/grey_texture.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

TEST(ProceduralTexture, NoiseIsTheVectorsGenerator) {
  const cv::Mat1d noise = procedural_texture("noise128");
  EXPECT_EQ(noise.size(), cv::Size(128, 128));
  EXPECT_EQ(noise(0, 0), 87628868 * 0x1p-32);
  EXPECT_EQ(noise(0, 1), 71072467 * 0x1p-32);
  EXPECT_EQ(noise(0, 2), 2332836374 * 0x1p-32);
}

TEST(ProceduralTexture, SizesAndValues) {
  EXPECT_EQ(procedural_texture("noise640x544").size(), cv::Size(640, 544));
  const cv::Mat1d small = procedural_texture("checker100x60"),
                  gradient = procedural_texture("gradient256");
  EXPECT_EQ(small.size(), cv::Size(100, 60));
  EXPECT_DOUBLE_EQ(small(0, 6), 0.2);
  EXPECT_DOUBLE_EQ(small(0, 7), 0.8);
  EXPECT_DOUBLE_EQ(small(7, 7), 0.2);
  EXPECT_DOUBLE_EQ(gradient(100, 0), 0.05);
  EXPECT_DOUBLE_EQ(gradient(3, 255), 0.95);
  EXPECT_THROW(procedural_texture("checker"), ArgumentError);
}

class GreyTexture : public ::testing::Test {
 protected:
  void expect_refused(const std::string& file) {
    try {
      read_grey_texture(folder_.path / file);
      FAIL() << file;
    } catch (const FileError& e) {
      EXPECT_NE(std::string(e.what()).find(file), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("; "), std::string::npos) << e.what();
    }
  }
  std::string path(const std::string& file) const { return (folder_.path / file).string(); }
  TemporaryFolder folder_;
};

TEST_F(GreyTexture, ExrWithOneChannelOrRgb) {
  ScalarImage y(3, 2, 0.25f);
  y.pixels(1, 2) = -0.5f;
  write_exr(path("y.exr"), y, "Y");
  const cv::Mat1d grey = read_grey_texture(path("y.exr"));
  EXPECT_EQ(grey(0, 0), 0.25);
  EXPECT_EQ(grey(1, 2), -0.5);

  RgbImage rgb(3, 2);
  rgb.pixels(1, 0) = {0.5f, 0.25f, 2};
  write_exr(path("rgb.exr"), rgb);
  EXPECT_DOUBLE_EQ(read_grey_texture(path("rgb.exr"))(1, 0),
                   0.298936021293775 * 0.5 + 0.587043074451121 * 0.25 + 0.114020904255103 * 2);
}

TEST_F(GreyTexture, PicturesAreDividedByTheirFullCode) {
  cv::imwrite(path("grey8.png"), cv::Mat1b(2, 3, 51));
  EXPECT_DOUBLE_EQ(read_grey_texture(path("grey8.png"))(1, 2), 0.2);
  cv::imwrite(path("grey16.png"), cv::Mat1w(2, 3, 13107));
  EXPECT_DOUBLE_EQ(read_grey_texture(path("grey16.png"))(1, 2), 0.2);
  cv::imwrite(path("rgb8.png"), cv::Mat3b(2, 3, cv::Vec3b(0, 51, 255)));  // stored B, G, R
  EXPECT_NEAR(read_grey_texture(path("rgb8.png"))(0, 0),
              0.298936021293775 + 0.587043074451121 * 0.2, 1e-15);
}

TEST_F(GreyTexture, UnusableFilesAreRefused) {
  expect_refused("missing.png");
  expect_refused("missing.exr");
  for (const char* file : {"text.png", "text.exr"}) {
    std::ofstream(path(file)) << "no picture";
    expect_refused(file);
  }
  std::ofstream(path("empty.png")).flush();
  expect_refused("empty.png");
  write_exr(path("depth.exr"), ScalarImage(2, 2), "Z");
  expect_refused("depth.exr");
  ScalarImage bad(4, 3, 0.5f);
  bad.pixels(2, 1) = std::numeric_limits<float>::quiet_NaN();
  write_exr(path("nan.exr"), bad, "Y");
  expect_refused("nan.exr");
}

// Damaged files: every outcome is a texture or a FileError.
TEST_F(GreyTexture, SurvivesDamage) {
  write_exr(path("good.exr"), ScalarImage(24, 16, 0.5f), "Y");
  cv::imwrite(path("good.png"), cv::Mat1w(16, 24, 1000));
  int errors = 0;
  for (const char* extension : {".exr", ".png"}) {
    const std::string good = read_text(path(std::string("good") + extension));
    for (std::uint64_t i = 0; i < 300; ++i) {
      RandomStream random(5, i);
      std::string bytes = good;
      for (std::uint64_t flips = 1 + random.next() % 3; flips > 0; --flips)
        bytes[random.next() % bytes.size()] ^= static_cast<char>(1u << (random.next() % 8));
      if (random.next() % 4 == 0) bytes.resize(random.next() % bytes.size());
      std::ofstream(path(std::string("bad") + extension), std::ios::binary) << bytes;
      try {
        read_grey_texture(path(std::string("bad") + extension));
      } catch (const FileError&) {
        ++errors;
      }
    }
  }
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace wheatstone
