#include "core/camera_raw.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

// A Canon EOS Kiss X4: 1888 x 1182 px, of which the active area is 1734 x 1156; 14 bit, RGGB, black
// 2056, white 15000; its exposure time is 0 / 1000000.
TEST(CameraRaw, ReadsWhatARealFileSays) {
  const auto file = shared_folder("data/exposure_stacks/raw_dng/colorchart.dng");
  REQUIRE_SHARED(file);
  const CameraRaw raw = read_camera_raw(file);
  EXPECT_EQ(raw.mosaic.width(), 1734);
  EXPECT_EQ(raw.mosaic.height(), 1156);
  EXPECT_EQ(raw.mosaic.pattern, BayerPattern::kRggb);
  for (const double black : raw.black_dn) EXPECT_NEAR(black, 2056, 1);
  EXPECT_EQ(raw.white_dn, 15000);
  EXPECT_EQ(raw.exposure_s, 0);
  EXPECT_THAT(raw.camera, testing::HasSubstr("Canon"));
  double low = 0, high = 0;
  cv::minMaxLoc(raw.mosaic.dn, &low, &high);
  EXPECT_GT(low, 1500);
  EXPECT_LT(high, 16384);
  EXPECT_GT(cv::mean(raw.mosaic.dn)[0], 2100);
}

TEST(CameraRaw, OtherFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& bytes) {
    const auto file = folder.path / "a.dng";
    write_text_atomically(file, bytes);
    try {
      read_camera_raw(file);
      FAIL();
    } catch (const FileError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(file.string()));
    }
  };
  refused("");
  refused("no photograph");
  refused(std::string("II*\0\x08\0\0\0", 8));
  EXPECT_THROW(read_camera_raw(folder.path / "none.dng"), FileError);
}

TEST(CameraRaw, DamagedFilesAreReadOrRefused) {
  const auto file = shared_folder("data/exposure_stacks/raw_dng/colorchart.dng");
  REQUIRE_SHARED(file);
  const std::string good = read_text(file);
  const TemporaryFolder folder;
  int read = 0, refused = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    RandomStream random(9, i);
    std::string bytes = good;
    const std::size_t flips = 1 + random.next() % 4;
    // Tags and sizes stand in the first kilobytes.
    for (std::size_t k = 0; k < flips; ++k)
      bytes[random.next() % 2000] ^= static_cast<char>(1U << (random.next() % 8));
    if (random.next() % 4 == 0) bytes.resize(random.next() % bytes.size());
    write_text_atomically(folder.path / "a.dng", bytes);
    try {
      const CameraRaw raw = read_camera_raw(folder.path / "a.dng");
      EXPECT_GE(raw.mosaic.width(), 2);
      ++read;
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 5);
  EXPECT_GT(refused, 5);
}

}  // namespace
}  // namespace wheatstone
