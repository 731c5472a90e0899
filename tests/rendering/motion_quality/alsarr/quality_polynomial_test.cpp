#include "rendering/motion_quality/alsarr/quality_polynomial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/csv.h"
#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "rendering/motion_quality/grey_texture.h"
#include "tests/rendering/motion_quality/vectors.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

std::vector<QualitySample> reference_samples(const std::string& gain_column) {
  const CsvTable t = read_vectors("polyfit_samples.csv");
  std::vector<QualitySample> out;
  for (std::size_t row = 0; row < t.rows(); ++row)
    out.push_back({t.number(row, "refresh_hz"), t.number(row, "velocity_deg_s"),
                   t.number(row, "log10_luminance"), t.number(row, gain_column)});
  return out;
}

TEST(QualityPolynomial, FitLikeTheReference) {
  const CsvTable expected = read_vectors("polyfit_result.csv");
  for (std::size_t row = 0; row < expected.rows(); ++row) {
    const auto samples = reference_samples("dQ_" + expected.text(row, "rate"));
    const QualityPolynomial p = fit_quality_polynomial(samples);
    for (std::size_t i = 0; i < p.w.size(); ++i) {
      const double w = expected.number(row, "W" + std::to_string(i));
      EXPECT_NEAR(p.w[i], w, 1e-9 * std::abs(w) + 1e-13) << expected.where(row) << " W" << i;
    }
    double squares = 0;
    for (const QualitySample& s : samples)
      squares +=
          std::pow(p(s.speed_deg_per_s, s.refresh_hz, std::pow(10, s.log10_luminance)) - s.gain, 2);
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(samples.size())),
                expected.number(row, "rms_residual"), 1e-7);
  }
}

TEST(QualityPolynomial, SamplesOfTheModelLikeTheReference) {
  const auto samples =
      sample_quality_gains(Camojab(CamojabTexture(procedural_texture("checker512"))), 0);
  for (std::size_t rate = 0; rate < 2; ++rate) {
    const auto expected = reference_samples(rate == 0 ? "dQ_half" : "dQ_full");
    ASSERT_EQ(samples[rate].size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(samples[rate][i].refresh_hz, expected[i].refresh_hz);
      EXPECT_EQ(samples[rate][i].speed_deg_per_s, expected[i].speed_deg_per_s);
      EXPECT_EQ(samples[rate][i].log10_luminance, expected[i].log10_luminance);
      // Ds to 1e-4 and Dt to 2e-5, each twice, times their weights.
      EXPECT_NEAR(samples[rate][i].gain, expected[i].gain, 9e-4) << i;
    }
  }
}

TEST(QualityPolynomial, WhatGainsNothingHasNoPolynomial) {
  auto samples = reference_samples("dQ_full");
  for (QualitySample& s : samples) s.gain *= 1e-4;  // below what counts
  for (const double w : fit_quality_polynomial(samples).w) EXPECT_EQ(w, 0);
}

TEST(QualityPolynomial, TheGridMustBeComplete) {
  auto samples = reference_samples("dQ_full");
  samples.erase(samples.begin() + 3);  // 30 Hz, speed 0, log10 luminance 2.5
  try {
    fit_quality_polynomial(samples);
    FAIL() << "accepted";
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), HasSubstr("30 Hz, 0 deg/s, log10 luminance 2.5"));
  }
}

PolynomialTable two_materials() {
  RandomStream random(5, 0);
  std::vector<PolynomialTable::Material> materials = {{"sky, \"blue\"", {}}, {"floor", {}}};
  for (auto& material : materials)
    for (auto& mip : material.mips)
      for (auto& polynomial : mip)
        for (double& w : polynomial.w) w = random.normal();
  return PolynomialTable(materials);
}

std::string text_of(const PolynomialTable& table) {
  const std::filesystem::path path = temporary_file("polynomials.csv");
  table.write(path);
  return read_text(path);
}

std::string error_of(const std::string& text) {
  const std::filesystem::path path = temporary_file("damaged.csv");
  write_text_atomically(path, text);
  try {
    PolynomialTable::read(path);
  } catch (const FileError& e) {
    return e.what();
  }
  return "no error";
}

TEST(PolynomialTable, ReadsBackWhatItWrites) {
  const PolynomialTable table = two_materials();
  text_of(table);
  const PolynomialTable back = PolynomialTable::read(temporary_file("polynomials.csv"));
  ASSERT_EQ(back.materials(), 2);
  EXPECT_EQ(back.material(0).name, "sky, \"blue\"");
  for (int material = 0; material < 2; ++material)
    for (int mip = 0; mip < kMipRows; ++mip)
      for (int rate = 0; rate < 2; ++rate)
        EXPECT_EQ(back.at(material, mip)[rate].w, table.at(material, mip)[rate].w);
  EXPECT_EQ(&back.at(1, 99), &back.at(1, kMipRows - 1));
  EXPECT_EQ(&back.at(1, -1), &back.at(1, 0));
}

TEST(PolynomialTable, DamagedTablesNameFileAndLine) {
  const std::string good = text_of(two_materials());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from, text.find('\n'));
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  EXPECT_EQ(error_of(good), "no error");
  EXPECT_THAT(error_of(with("half,1,", "half,0,")),
              testing::AllOf(HasSubstr("damaged.csv:2"), HasSubstr("mip_index_1based is 0")));
  EXPECT_THAT(error_of(with("half,1,", "third,1,")), HasSubstr("rate is 'third'"));
  EXPECT_THAT(error_of(with("half,2,", "half,1,")),
              testing::AllOf(HasSubstr("damaged.csv:3"), HasSubstr("repeats")));
  EXPECT_THAT(error_of(with("half,1,", "half,1,nan,")), HasSubstr("line 2 has 15 cells"));
  EXPECT_THAT(error_of(with("2,floor,half,1,", "90000,floor,half,1,")),
              HasSubstr("48 rows for 90000 materials"));
  EXPECT_THAT(error_of(good.substr(0, good.rfind('\n', good.size() - 2) + 1)),
              HasSubstr("give 48 rows"));
  EXPECT_THAT(error_of("material_index,rate\n"), HasSubstr("0 rows"));
  std::string header = good;
  header.replace(header.find("W9"), 2, "X9");
  EXPECT_THAT(error_of(header), HasSubstr("no column 'W9'"));
}

TEST(PolynomialTable, EveryDamageIsAnErrorOrATable) {
  const std::string good = text_of(two_materials());
  int errors = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    RandomStream random(3, i);
    std::string text = good;
    for (std::uint64_t k = 0; k < 1 + random.next() % 3; ++k)
      text[random.next() % text.size()] ^= static_cast<char>(1u << random.next() % 8);
    if (random.next() % 3 == 0) text.resize(random.next() % text.size());
    errors += error_of(text) != "no error";
  }
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace wheatstone
