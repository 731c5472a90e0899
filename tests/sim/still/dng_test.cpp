#include "sim/wire/still/dng.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/camera_raw.h"
#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

DngPicture picture(int width, int height, BayerPattern pattern) {
  DngPicture p;
  p.mosaic = {cv::Mat1w(height, width), pattern};
  RandomStream random(5, static_cast<std::uint64_t>(width));
  for (std::uint16_t& code : p.mosaic.dn) code = static_cast<std::uint16_t>(random.next());
  p.black_dn = 512;
  p.white_dn = 15360;
  p.exposure_numerator = 13;
  p.exposure_denominator = 10;
  p.iso = 100;
  p.make = "Sony";
  p.model = "ILCE-7RM3";
  p.serial = "SIM-0001";
  return p;
}

TEST(Dng, LibRawReadsItBackBitForBit) {
  for (const BayerPattern pattern :
       {BayerPattern::kRggb, BayerPattern::kBggr, BayerPattern::kGrbg, BayerPattern::kGbrg})
    for (const auto& [width, height] : {std::pair(148, 98), std::pair(75, 53)}) {
      const DngPicture p = picture(width, height, pattern);
      const CameraRaw raw = decode_camera_raw(dng_file(p), "a.dng");
      ASSERT_EQ(raw.mosaic.dn.size(), p.mosaic.dn.size());
      EXPECT_EQ(cv::norm(raw.mosaic.dn, p.mosaic.dn, cv::NORM_INF), 0);
      EXPECT_EQ(raw.mosaic.pattern, pattern);
      EXPECT_THAT(raw.black_dn, testing::Each(512));
      EXPECT_EQ(raw.white_dn, 15360);
      EXPECT_EQ(raw.exposure_s, 13.0 / 10);
      EXPECT_EQ(raw.iso, 100);
      EXPECT_EQ(raw.serial, "SIM-0001");
      EXPECT_THAT(raw.camera, testing::HasSubstr("ILCE-7RM3"));
    }
}

TEST(Dng, CutFilesAreRefused) {
  const std::vector<std::byte> whole = dng_file(picture(148, 98, BayerPattern::kRggb));
  for (const std::size_t kept : {std::size_t{0}, std::size_t{7}, std::size_t{300}})
    EXPECT_THROW(decode_camera_raw(std::span(whole).first(kept), "a.dng"), FileError) << kept;
}

}  // namespace
}  // namespace wheatstone
