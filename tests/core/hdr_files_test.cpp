#include "core/hdr_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

class HdrFiles : public ::testing::Test {
 protected:
  std::filesystem::path store(const std::string& bytes, const std::string& name) {
    const std::filesystem::path path = folder_.path / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  RgbImage pfm(const std::string& bytes) { return read_pfm(store(bytes, "picture.pfm")); }
  RgbImage radiance(const std::string& bytes) {
    return read_radiance_hdr(store(bytes, "picture.hdr"));
  }
  template <class Read>
  void expect_refused(Read read, const std::string& part) {
    try {
      read();
      ADD_FAILURE() << "accepted; expected '" << part << "'";
    } catch (const FileError& e) {
      EXPECT_THAT(e.what(), HasSubstr(part));
      EXPECT_THAT(e.what(), HasSubstr("picture."));
    }
  }

  const TemporaryFolder folder_;
};

std::string floats(std::initializer_list<float> values, bool little_endian = true) {
  std::string out;
  for (const float v : values)
    for (int i = 0; i < 4; ++i)
      out += static_cast<char>(std::bit_cast<std::uint32_t>(v) >> 8 * (little_endian ? i : 3 - i));
  return out;
}

TEST_F(HdrFiles, PfmRowsComeFromTheBottomInEitherByteOrder) {
  for (const bool little : {true, false}) {
    const RgbImage image = pfm(std::string("PF\n2 2\n") + (little ? "-1.0\n" : "1.0\n") +
                               floats({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, little));
    EXPECT_EQ(image.pixels(0, 0), cv::Vec3f(7, 8, 9));
    EXPECT_EQ(image.pixels(1, 1), cv::Vec3f(4, 5, 6));
  }
  EXPECT_EQ(pfm("Pf 1 2 -1\n" + floats({3, 0.25F})).pixels(0, 0), cv::Vec3f(0.25F, 0.25F, 0.25F));
}

TEST_F(HdrFiles, DamagedPfmIsRefused) {
  const std::string pixel = floats({1, 2, 3});
  for (const auto& [bytes, part] : std::initializer_list<std::pair<std::string, const char*>>{
           {"", "header"},
           {"P6\n1 1\n-1\n" + pixel, "no Portable Float Map"},
           {"PF\n1 x\n-1\n" + pixel, "header"},
           {"PF\n1 1\n-1", "header"},
           {"PF\n0 1\n-1\n" + pixel, "no pixels"},
           {"PF\n-3 1\n-1\n" + pixel, "no pixels"},
           {"PF\n2000000000 2000000000\n-1\n" + pixel, "200 Mpixel"},
           {"PF\n99999999999999999999 1\n-1\n" + pixel, "header"},
           {"PF\n16384 12000\n-1\n" + pixel, "its header promises"},
           {"PF\n1 1\n-1\n" + pixel + "x", "holds 13 bytes"},
           {"PF\n1 1\n-1\n" + pixel.substr(1), "holds 11 bytes"},
           {"PF\n1 1\n-2.5\n" + pixel, "scale factor"},
           {"PF\n1 1\n0\n" + pixel, "scale factor"},
           {"PF\n1 1\nnan\n" + pixel, "scale factor"},
           {"PF\n1 1\n-1\n" + floats({1, -2, 3}), "1 negative"},
           {"PF\n1 1\n-1\n" + floats({1, 2, std::numeric_limits<float>::infinity()}), "1 infinite"},
           {"PF\n1 1\n-1\n" + floats({std::numeric_limits<float>::quiet_NaN(), 2, 3}), "1 NaN"}})
    expect_refused([&, b = bytes] { pfm(b); }, part);
  expect_refused([&] { read_pfm(folder_.path / "picture.none"); }, "is missing");
}

const std::string kHeader = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n";

TEST_F(HdrFiles, RadianceFlatPixels) {
  const RgbImage image = radiance(kHeader + "\n-Y 2 +X 1\n" + std::string("\x80\x40\x20\x81", 4) +
                                  std::string("\xff\x00\x01\x00", 4));
  // mantissa * 2^(exponent - 136)
  EXPECT_EQ(image.pixels(0, 0), cv::Vec3f(1, 0.5F, 0.25F));
  EXPECT_EQ(image.pixels(1, 0), cv::Vec3f(0, 0, 0));  // exponent 0 is black
}

/// A row of nine pixels, each component as a run of eight and one literal.
std::string coded_row() {
  std::string row("\x02\x02\x00\x09", 4);
  for (const char v : {'\x80', '\x40', '\x20', '\x81'})
    row += std::string{static_cast<char>(128 + 8), v, 1, v};
  return row;
}

TEST_F(HdrFiles, RadianceRunLengths) {
  const RgbImage image = radiance(kHeader + "\n-Y 2 +X 9\n" + coded_row() + coded_row());
  for (const cv::Vec3f& p : image.pixels) EXPECT_EQ(p, cv::Vec3f(1, 0.5F, 0.25F));
}

TEST_F(HdrFiles, RadianceExposuresAreDividedOut) {
  const RgbImage image =
      radiance(kHeader + "EXPOSURE=4\nEXPOSURE= 0.5\n\n-Y 1 +X 9\n" + coded_row());
  EXPECT_EQ(image.pixels(0, 8), cv::Vec3f(0.5F, 0.25F, 0.125F));
}

TEST_F(HdrFiles, RadianceThatMeansOtherLightIsRefused) {
  const std::string rest = "\n-Y 1 +X 9\n" + coded_row();
  EXPECT_NO_THROW(
      radiance(kHeader + "PRIMARIES= 0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290\n" + rest));
  for (const auto& [bytes, part] : std::initializer_list<std::pair<std::string, const char*>>{
           {"", "header"},
           {"PF\n" + rest, "no Radiance picture"},
           {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n" + rest, "32-bit_rle_xyze"},
           {kHeader + "COLORCORR=1 1 2\n" + rest, "COLORCORR"},
           {kHeader + "PRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.33 0.33\n" + rest, "primaries"},
           {kHeader + "EXPOSURE=\n" + rest, "EXPOSURE"},
           {kHeader + "EXPOSURE=-1\n" + rest, "EXPOSURE"},
           {kHeader + "EXPOSURE=nan\n" + rest, "EXPOSURE"},
           {kHeader + "\n+Y 1 +X 9\n" + coded_row(), "'+Y +X'"},
           {kHeader + "\n-X 1 +Y 9\n" + coded_row(), "'-X +Y'"},
           {kHeader + "\n-Y 1\n" + coded_row(), "size line"},
           {kHeader + "\n-Y 1 +X 9 more\n" + coded_row(), "size line"},
           {kHeader + "\n-Y 0 +X 9\n" + coded_row(), "no pixels"},
           {kHeader + "\n-Y 16384 +X 16384\n" + coded_row(), "200 Mpixel"},
           {kHeader + "\n-Y 16384 +X 9\n" + coded_row(), "shorter than its header"},
           {kHeader + "\n-Y 1 +X 9\n" + coded_row().substr(0, 17), "shorter than its header"},
           {kHeader + "\n-Y 1 +X 10\n" + coded_row() + "12", "another length"},
           {kHeader + "\n-Y 1 +X 9\n\x02\x02" + std::string("\x00\x09\x00", 3) +
                std::string(20, 'x'),
            "run length"},
           {kHeader + "\n-Y 1 +X 9\n\x02\x02" + std::string("\x00\x09\xff", 3) +
                std::string(20, 'x'),
            "run length"},
           {kHeader + "\n-Y 1 +X 2\n\x80\x40\x20\x81\x01\x01\x01\x05", "before 1991"}})
    expect_refused([&, b = bytes] { radiance(b); }, part);
}

TEST_F(HdrFiles, RadiancePhotographAsOpenCvReadsIt) {
  const auto file = shared_folder("reference/metrics/data/nancy_church.hdr");
  REQUIRE_SHARED(file);
  const RgbImage image = read_radiance_hdr(file);
  ASSERT_EQ(image.width(), 768);
  ASSERT_EQ(image.height(), 1024);
  const cv::Mat3f theirs = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  cv::Mat3f rgb;
  cv::mixChannels(std::vector<cv::Mat>{theirs}, std::vector<cv::Mat>{rgb = theirs.clone()},
                  {0, 2, 1, 1, 2, 0});
  EXPECT_EQ(cv::norm(image.pixels, rgb, cv::NORM_INF), 0);
  double peak = 0;
  cv::minMaxLoc(image.pixels.reshape(1), nullptr, &peak);
  EXPECT_EQ(peak, 5344);
}

struct Outcomes {
  int images = 0, errors = 0;
};

/// Damages a good file in many ways: every outcome is an image or an Error.
Outcomes fuzz(const std::string& good, const std::filesystem::path& path,
              RgbImage (*read)(const std::filesystem::path&), std::uint64_t seed) {
  Outcomes out;
  for (std::uint64_t i = 0; i < 3000; ++i) {
    RandomStream random(seed, i);
    std::string bytes = good;
    for (std::uint64_t flips = random.next() % 4; flips > 0; --flips) {
      // Half of the flips go to the header and the first row's beginning.
      const std::size_t range =
          random.next() % 2 ? bytes.size() : std::min<std::size_t>(80, bytes.size());
      bytes[random.next() % range] ^= static_cast<char>(1U << (random.next() % 8));
    }
    if (random.next() % 4 == 0) bytes.resize(random.next() % bytes.size());
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      const RgbImage image = read(path);
      require_valid_radiance(image, "the image");
      ++out.images;
    } catch (const Error&) {
      ++out.errors;
    }
  }
  return out;
}

TEST_F(HdrFiles, FuzzedPfm) {
  const Outcomes o = fuzz("PF\n2 2\n-1.0\n" + floats({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}),
                          folder_.path / "fuzzed.pfm", read_pfm, 1);
  EXPECT_GT(o.errors, 500);
  EXPECT_GT(o.images, 200);
}

TEST_F(HdrFiles, FuzzedRadiance) {
  const Outcomes o =
      fuzz(kHeader + "EXPOSURE=2\n\n-Y 3 +X 9\n" + coded_row() + coded_row() + coded_row(),
           folder_.path / "fuzzed.hdr", read_radiance_hdr, 2);
  EXPECT_GT(o.errors, 500);
  EXPECT_GT(o.images, 200);
}

}  // namespace
}  // namespace wheatstone
