#include "core/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <random>
#include <string>

#include "core/error.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

class ExrTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "exr_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

RgbImage random_image(int width, int height, float largest) {
  RgbImage image(width, height);
  std::mt19937 generator(7);
  std::uniform_real_distribution<float> exponent(std::log(1e-3F), std::log(largest));
  for (cv::Vec3f& pixel : image.pixels)
    for (int k = 0; k < 3; ++k) pixel[k] = std::exp(exponent(generator));
  return image;
}

/// A file straight from OpenEXR: one value everywhere in R, G, B of `type`, then one odd sample.
void write_raw(const fs::path& path, float odd, Imath::Box2i display, Imath::Box2i data,
               Imf::Header header = Imf::Header()) {
  header.displayWindow() = display;
  header.dataWindow() = data;
  const int width = data.max.x - data.min.x + 1, height = data.max.y - data.min.y + 1;
  std::vector<float> values(static_cast<std::size_t>(width * height), 0.5F);
  std::vector<float> green = values;
  green[static_cast<std::size_t>(1 * width + 2)] = odd;
  Imf::FrameBuffer buffer;
  for (const char* name : {"R", "G", "B"}) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name,
                  Imf::Slice::Make(Imf::FLOAT, *name == 'G' ? green.data() : values.data(), data));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

std::string error_of(const fs::path& path) {
  try {
    read_exr(path);
  } catch (const FileError& e) {
    return e.what();
  }
  return "";
}

TEST_F(ExrTest, FloatRoundTripIsExact) {
  const RgbImage image = random_image(37, 21, 1e6F);
  write_exr(folder_ / "a.exr", image, ExrPrecision::kFloat);
  ExrMetadata metadata;
  const RgbImage back = read_exr(folder_ / "a.exr", &metadata);
  ASSERT_EQ(back.pixels.size(), image.pixels.size());
  EXPECT_EQ(cv::norm(back.pixels, image.pixels, cv::NORM_INF), 0);
  EXPECT_EQ(metadata.white_luminance_cd_m2, 1);
  EXPECT_TRUE(metadata.has_bt709_chromaticities);
}

TEST_F(ExrTest, HalfRoundTripLosesAtMostHalfAPerMille) {
  RgbImage image = random_image(37, 21, 65504.0F);
  image.pixels(0, 0) = {65504.0F, 0.0F, 1.0F};
  const RgbImage window(cv::Mat3f(image.pixels(cv::Rect(0, 0, 30, 20))));  // rows not contiguous
  write_exr(folder_ / "a.exr", window, ExrPrecision::kHalf);
  const RgbImage back = read_exr(folder_ / "a.exr");
  ASSERT_EQ(back.pixels.size(), window.pixels.size());
  for (int r = 0; r < back.height(); ++r)
    for (int c = 0; c < back.width(); ++c)
      for (int k = 0; k < 3; ++k)
        ASSERT_NEAR(back.pixels(r, c)[k], window.pixels(r, c)[k], 0.0005 * window.pixels(r, c)[k]);
}

TEST_F(ExrTest, ScalarRoundTripIsExact) {
  ScalarImage depth(5, 4, 2.5F);
  depth.pixels(3, 1) = 7.25F;
  write_exr(folder_ / "z.exr", depth, "Z");
  const auto views = read_exr_views(folder_ / "z.exr");
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].name, "");
  EXPECT_EQ(views[0].width_px, 5);
  EXPECT_EQ(cv::norm(views[0].channels.at("Z").pixels, depth.pixels, cv::NORM_INF), 0);
  EXPECT_THROW(read_exr(folder_ / "z.exr"), FileError);  // no R, G, B
}

TEST_F(ExrTest, WriterRefusesWhatItCannotKeep) {
  RgbImage image(3, 2);
  image.pixels(1, 1)[0] = 65505.0F;
  EXPECT_THROW(write_exr(folder_ / "a.exr", image, ExrPrecision::kHalf), ArgumentError);
  image.pixels(1, 1)[0] = std::nanf("");
  EXPECT_THROW(write_exr(folder_ / "a.exr", image), ArgumentError);
  EXPECT_THROW(write_exr(folder_ / "a.exr", RgbImage()), ArgumentError);
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_THROW(write_exr(folder_ / "none" / "a.exr", RgbImage(3, 2)), FileError);
}

TEST_F(ExrTest, ImpossibleRadianceIsRefusedWithItsPlace) {
  const Imath::Box2i window({0, 0}, {7, 5});
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float odd : {std::nanf(""), kInfinity, -kInfinity, -0.25F}) {
    const fs::path path = folder_ / "odd.exr";
    write_raw(path, odd, window, window);
    const std::string error = error_of(path);
    EXPECT_NE(error.find("column 2, row 1"), std::string::npos) << odd << ": " << error;
    EXPECT_NE(error.find(path.string()), std::string::npos);
    EXPECT_NO_THROW(read_exr_views(path));  // views are not judged
  }
}

TEST_F(ExrTest, DataWindowIsPlacedInTheDisplayWindow) {
  const fs::path path = folder_ / "placed.exr";
  // Display columns 10..19, rows 20..25; the data reach out at the top left.
  write_raw(path, 3.0F, Imath::Box2i({10, 20}, {19, 25}), Imath::Box2i({9, 19}, {13, 22}));
  const RgbImage image = read_exr(path);
  ASSERT_EQ(image.pixels.size(), cv::Size(10, 6));
  EXPECT_EQ(image.pixels(0, 1), cv::Vec3f(0.5F, 3.0F, 0.5F));  // data (2, 1) is file (11, 20)
  EXPECT_EQ(image.pixels(2, 3), cv::Vec3f(0.5F, 0.5F, 0.5F));
  EXPECT_EQ(image.pixels(2, 4), cv::Vec3f(0, 0, 0));
  EXPECT_EQ(image.pixels(3, 3), cv::Vec3f(0, 0, 0));
  EXPECT_EQ(cv::countNonZero(image.pixels.reshape(1)), 4 * 3 * 3);
}

TEST_F(ExrTest, ForeignPrimariesAndWhiteAreReported) {
  Imf::Header header;
  Imf::addChromaticities(header, Imf::Chromaticities({0.708F, 0.292F}, {0.17F, 0.797F},
                                                     {0.131F, 0.046F}, {0.3127F, 0.329F}));
  Imf::addWhiteLuminance(header, 100.0F);
  const Imath::Box2i window({0, 0}, {7, 5});
  write_raw(folder_ / "a.exr", 1, window, window, header);
  ExrMetadata metadata;
  read_exr(folder_ / "a.exr", &metadata);
  EXPECT_FALSE(metadata.has_bt709_chromaticities);
  EXPECT_EQ(metadata.white_luminance_cd_m2, 100);
}

TEST_F(ExrTest, MissingFolderAndTextAreFileErrors) {
  std::ofstream(folder_ / "text.exr") << "not an image";
  std::ofstream(folder_ / "empty.exr");
  for (const fs::path& path :
       {folder_ / "none.exr", folder_, folder_ / "text.exr", folder_ / "empty.exr"}) {
    EXPECT_NE(error_of(path).find(path.string()), std::string::npos) << path;
    EXPECT_THROW(read_exr_views(path), FileError) << path;
  }
}

TEST_F(ExrTest, EveryTruncationIsRefused) {
  const fs::path whole = folder_ / "whole.exr", cut = folder_ / "cut.exr";
  write_exr(whole, random_image(13, 40, 100));
  const auto size = fs::file_size(whole);
  for (std::uintmax_t length = 0; length < size; length += length < 600 ? 1 : 53) {
    fs::copy_file(whole, cut, fs::copy_options::overwrite_existing);
    fs::resize_file(cut, length);
    ASSERT_NE(error_of(cut), "") << length << " of " << size << " bytes";
  }
}

TEST_F(ExrTest, HeaderThatPromisesFarTooMuchIsRefused) {
  const Imath::Box2i small({0, 0}, {7, 5});
  for (const int side : {16384, 20000, 14000}) {
    const fs::path path = folder_ / "huge.exr";
    write_raw(path, 1, Imath::Box2i({0, 0}, {side - 1, side - 1}), small);
    EXPECT_NE(error_of(path), "") << side;
  }
}

TEST_F(ExrTest, EmptyRegionOfAnOrdinaryFrameIsRead) {
  // A 4K frame with a tiny data window is a short file, yet honest.
  const fs::path path = folder_ / "region.exr";
  write_raw(path, 1, Imath::Box2i({0, 0}, {3839, 2159}), Imath::Box2i({5, 5}, {12, 10}));
  EXPECT_EQ(read_exr(path).pixels.size(), cv::Size(3840, 2160));
}

/// Exit status of exr_probe on `path`: 0 if it was read or refused with FileError. Signals are
/// given as 128 + signal.
int probe(const fs::path& path, bool views) {
  const pid_t child = fork();
  if (child == 0) {
    execl(WHEATSTONE_EXR_PROBE, WHEATSTONE_EXR_PROBE, views ? "views" : "read", path.c_str(),
          nullptr);
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return 255;
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

TEST(DamagedExr, EveryFileIsReadOrRefusedWithinBounds) {
  const fs::path folder = shared_folder("data") / "damaged_exr";
  REQUIRE_SHARED(folder);
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_EQ(probe(entry.path(), false), 0) << "read_exr " << entry.path();
    EXPECT_EQ(probe(entry.path(), true), 0) << "read_exr_views " << entry.path();
    ++files;
  }
  EXPECT_GE(files, 90);
}

TEST_F(ExrTest, FlippedBytesAreReadOrRefusedWithinBounds) {
  const fs::path whole = folder_ / "whole.exr", bad = folder_ / "bad.exr";
  write_exr(whole, random_image(13, 40, 100), ExrPrecision::kHalf);
  std::mt19937 generator(11);
  for (int i = 0; i < 100; ++i) {
    fs::copy_file(whole, bad, fs::copy_options::overwrite_existing);
    std::fstream file(bad, std::ios::in | std::ios::out | std::ios::binary);
    for (int k = 0; k < 3; ++k) {
      file.seekp(static_cast<std::streamoff>(generator() % 500));
      file.put(static_cast<char>(generator()));
    }
    file.close();
    ASSERT_EQ(probe(bad, i % 2 == 0), 0) << "variant " << i;
  }
}

/// Mean of |right(x) - left(x + disparityL.x)| over pixels where the ball is opaque; checks Z.
double disparity_error(const ExrView& right, const ExrView& left, const ScalarImage& disparity_px) {
  double sum = 0;
  int count = 0;
  for (int r = 0; r < right.height_px; r += 3)
    for (int c = 0; c < right.width_px; c += 3) {
      if (right.channels.at("A").pixels(r, c) != 1) continue;
      const float z = right.channels.at("Z").pixels(r, c);
      EXPECT_TRUE(z > 8.99F && z < 10.91F) << z;
      const float x = static_cast<float>(c) + disparity_px.pixels(r, c);
      const int x0 = static_cast<int>(std::floor(x));
      if (x0 < 0 || x0 + 1 >= left.width_px) continue;
      const float f = x - static_cast<float>(x0);
      for (const char* name : {"R", "G", "B"}) {
        const cv::Mat1f& colour = left.channels.at(name).pixels;
        sum += std::abs(right.channels.at(name).pixels(r, c) -
                        ((1 - f) * colour(r, x0) + f * colour(r, x0 + 1)));
        ++count;
      }
    }
  EXPECT_GT(count, 10000);
  return sum / count;
}

TEST(ExrViews, SinglePartStereoAgreesWithItsDisparity) {
  const fs::path folder = shared_folder("data") / "openexr_stereo";
  REQUIRE_SHARED(folder);
  const auto views = read_exr_views(folder / "beachball" / "singlepart.0001.exr");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].name, "right");
  EXPECT_EQ(views[1].name, "left");
  EXPECT_EQ(views[0].width_px, 2048);
  EXPECT_EQ(views[0].height_px, 1556);
  EXPECT_LT(disparity_error(views[0], views[1], views[0].channels.at("disparityL.x")), 0.001);
}

TEST(ExrViews, MultiPartViewsComeFromTheParts) {
  const fs::path folder = shared_folder("data") / "openexr_stereo";
  REQUIRE_SHARED(folder);
  const auto views = read_exr_views(folder / "beachball" / "multipart.0008.exr");
  ASSERT_EQ(views.size(), 2U);
  const bool right_first = views[0].name == "right";
  const ExrView& right = views[right_first ? 0 : 1];
  const ExrView& left = views[right_first ? 1 : 0];
  EXPECT_EQ(right.name, "right");
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(right.width_px, 2048);
  EXPECT_EQ(right.height_px, 1556);
  for (const char* name : {"R", "G", "B", "A", "Z"}) {
    EXPECT_TRUE(right.channels.contains(name)) << name;
    EXPECT_TRUE(left.channels.contains(name)) << name;
  }
  EXPECT_LT(disparity_error(right, left, right.channels.at("disparityL.x")), 0.001);
}

TEST(ExrViews, LuminanceOnlyPairIsReadAndDeepIsRefused) {
  const fs::path folder = shared_folder("data") / "openexr_stereo";
  REQUIRE_SHARED(folder);
  const auto views = read_exr_views(folder / "multiview" / "Fog.exr");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].name, "left");
  EXPECT_EQ(views[1].name, "right");
  for (const ExrView& view : views) {
    ASSERT_EQ(view.channels.size(), 1U);
    EXPECT_EQ(view.channels.at("Y").pixels.size(), cv::Size(1000, 672));
    EXPECT_GT(cv::mean(view.channels.at("Y").pixels)[0], 0);
  }
  EXPECT_THROW(read_exr(folder / "multiview" / "Fog.exr"), FileError);
  EXPECT_THROW(read_exr(folder / "deep" / "Trunks.exr"), FileError);
  EXPECT_THROW(read_exr_views(folder / "deep" / "Trunks.exr"), FileError);
  EXPECT_FALSE(read_exr(folder / "deep" / "composited.exr").empty());
}

}  // namespace
}  // namespace wheatstone
