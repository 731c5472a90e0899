// Spectra to light, and what a specbos and spotread say.

#include <gmock/gmock.h>

#include "core/colour.h"
#include "core/colour_matching.h"
#include "core/error.h"
#include "hardware/argyll/spotread_output.h"
#include "hardware/serial/jeti_message.h"
#include "hardware/spectroradiometer.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

TEST(ColourMatching, SumsAreThoseOfTheStandard) {
  // CIE 15: the sums over 360 to 830 nm in steps of 5 nm are 21.3714 each, so that equal energy is
  // white.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (double nm = kFirstVisibleNm; nm <= kLastVisibleNm; nm += 5)
    sum += cie_1931_colour_matching(nm);
  EXPECT_NEAR(sum.x(), 21.3714, 0.002);
  EXPECT_NEAR(sum.y(), 21.3714, 0.0002);
  EXPECT_NEAR(sum.z(), 21.3714, 0.008);
}

TEST(ColourMatching, IsLinearBetweenItsValuesAndZeroOutside) {
  EXPECT_EQ(cie_1931_colour_matching(555).y(), 1);
  EXPECT_NEAR(cie_1931_colour_matching(557.5).y(), (1 + 0.995) / 2, 1e-12);
  EXPECT_EQ(cie_1931_colour_matching(359.9), Eigen::Vector3d::Zero());
  EXPECT_EQ(cie_1931_colour_matching(830.1), Eigen::Vector3d::Zero());
  EXPECT_GT(cie_1931_colour_matching(830).y(), 0);
}

TEST(Spectrum, ALineAt555NmHas683LumensPerWatt) {
  SpectralRadiance line{550, 1, std::vector<double>(11)};
  line.values[5] = 2;
  EXPECT_NEAR(xyz_cd_m2(line).y(), 2 * 683, 1e-9);
}

TEST(Spectrum, EqualEnergyIsWhite) {
  const SpectralRadiance equal{360, 1, std::vector<double>(471, 1e-3)};
  const Eigen::Vector3d xyz = xyz_cd_m2(equal);
  EXPECT_NEAR(xyz.x() / xyz.sum(), 1 / 3.0, 1e-4);
  EXPECT_NEAR(xyz.y() / xyz.sum(), 1 / 3.0, 1e-4);
}

TEST(Spectrum, RefusesWhatIsNone) {
  EXPECT_THROW(xyz_cd_m2({380, 1, {1}}), ArgumentError);
  EXPECT_THROW(xyz_cd_m2({380, 0, {1, 1}}), ArgumentError);
  EXPECT_THROW(xyz_cd_m2({380, 21, {1, 1}}), ArgumentError);
  EXPECT_THROW(xyz_cd_m2({380, 1, {1, std::nan("")}}), ArgumentError);
  EXPECT_THROW(xyz_cd_m2({std::nan(""), 1, {1, 1}}), ArgumentError);
}

TEST(Spectrum, AgreementIsWithinOnePercentOfEachPart) {
  const Eigen::Vector3d ours(90, 100, 2);
  EXPECT_TRUE(agree(ours, {90.9, 99, 2.1}));
  EXPECT_FALSE(agree(ours, {90, 101.2, 2}));
  EXPECT_FALSE(agree(ours, {90, 100, 2.2}));
}

TEST(JetiTokens, ComeInOrder) {
  std::string bytes = "JETI_\x05SB1211\r\n\x06\x07laser: 1\r\x15half";
  std::vector<std::string> seen;
  while (const auto token = take_token("it", bytes))
    seen.push_back(token->kind == JetiToken::Kind::kText   ? token->text
                   : token->kind == JetiToken::Kind::kAck  ? "ACK"
                   : token->kind == JetiToken::Kind::kBell ? "BELL"
                                                           : "NAK");
  EXPECT_THAT(seen, ::testing::ElementsAre("JETI_SB1211", "ACK", "BELL", "laser: 1", "NAK"));
  EXPECT_EQ(bytes, "half");
  bytes.assign(161, 'x');
  EXPECT_THROW(take_token("it", bytes), DeviceError);
  EXPECT_TRUE(bytes.empty());
}

TEST(JetiNumbers, AreFoundByTheirLabels) {
  EXPECT_EQ(jeti_number("it", "Predefined start wave: 380", "predefined START wave"), 380);
  EXPECT_EQ(jeti_number("it", "Chrom_x: 0.3 Chrom_y: 0.4", "Chrom_y"), 0.4);
  EXPECT_EQ(jeti_number("it", "Error Code: 120 overexposed", "Error Code"), 120);
  for (const char* line : {"", "laser", "laser: ", "laser: on", "laser: nan", "laser: 1x"})
    EXPECT_THROW(jeti_number("it", line, "laser"), DeviceError) << line;
  EXPECT_EQ(jeti_value(" 1.5E-3 "), 1.5e-3);
  for (const char* line : {"", " ", "1 2", "1.5E-31.2E-3", "inf"})
    EXPECT_EQ(jeti_value(line), std::nullopt) << line;
}

TEST(JetiErrors, ConcernTheCallerAsTheyShould) {
  EXPECT_EQ(jeti_error("it", "*init", 120).kind(), Kind::kTooBright);
  EXPECT_EQ(jeti_error("it", "*init", 121).kind(), Kind::kTooDark);
  EXPECT_EQ(jeti_error("it", "*init", 123).kind(), Kind::kRefused);
  EXPECT_EQ(jeti_error("it", "*init", 10).kind(), Kind::kRefused);
  EXPECT_EQ(jeti_error("it", "*init", 225).kind(), Kind::kFault);
  EXPECT_THAT(jeti_error("it", "*init", 120).what(), ::testing::HasSubstr("overexposed"));
}

TEST(SpotreadResults, TheLastOneCounts) {
  EXPECT_EQ(*parse_spotread_xyz(" Result is XYZ: 1 2 3, Yxy: ...\n Result is XYZ: 4 5 6, Yxy"),
            Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(parse_spotread_xyz("Spot read failed"), std::nullopt);
  EXPECT_EQ(parse_spotread_xyz("Result is XYZ: 1 2, 3"), std::nullopt);
}

const std::string kHead =
    "SPECT\n# SPECTRAL_BANDS \"9\"\nKEYWORD \"SPECTRAL_BANDS\"\nSPECTRAL_BANDS \"3\"\n"
    "SPECTRAL_START_NM \"380.0\"\nSPECTRAL_END_NM \"390.0\"\nSPECTRAL_NORM \"100.0\"\n"
    "NUMBER_OF_FIELDS 3\nBEGIN_DATA_FORMAT\nSPEC_380 SPEC_385 SPEC_390\nEND_DATA_FORMAT\n";

TEST(CgatsSpectra, AreReadInWatts) {
  const SpectralRadiance s =
      parse_cgats_spectrum("it", kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n100 200\n300\nEND_DATA\n");
  EXPECT_EQ(s.first_nm, 380);
  EXPECT_EQ(s.step_nm, 5);
  EXPECT_THAT(s.values, ::testing::ElementsAre(1e-3, 2e-3, 3e-3));
}

TEST(CgatsSpectra, RefusalsSayWhy) {
  const auto why = [](const std::string& text) {
    return error_of([&] { parse_cgats_spectrum("spotread", text); });
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(why(""), HasSubstr("no CGATS"));
  EXPECT_THAT(why("CTI3\n"), HasSubstr("no CGATS"));
  EXPECT_THAT(why("SPECT\n"), HasSubstr("without SPECTRAL_BANDS"));
  EXPECT_THAT(why(kHead + "NUMBER_OF_SETS 2\n"), HasSubstr("more than one"));
  EXPECT_THAT(why(kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n1 2 3\n"), HasSubstr("without its end"));
  EXPECT_THAT(why(kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n1 2\nEND_DATA"),
              HasSubstr("2 values for 3 bands"));
  EXPECT_THAT(why(kHead + "NUMBER_OF_SETS 1\nBEGIN_DATA\n1 x 3\nEND_DATA"), HasSubstr("no number"));
}

}  // namespace
}  // namespace wheatstone
