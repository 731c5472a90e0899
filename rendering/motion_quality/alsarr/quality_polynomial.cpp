#include "rendering/motion_quality/alsarr/quality_polynomial.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/csv.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr const char* kRateNames[] = {"half", "full"};  // by AxisRate
constexpr double kNoGain = 1e-4;
constexpr double kLuminanceRefresh_hz = 105;  // where the second factor is read off, at speed 0

std::array<double, 6> motion_terms(double v, double f) {
  return {1, v, f, v * v, v * f, f * f};
}

/// A whole number in low..high, from a cell.
int index_cell(const CsvTable& table, std::size_t row, const std::string& column, int low,
               int high) {
  const double value = table.finite_number(row, column);
  if (value < low || value > high || value != std::floor(value))
    throw FileError(table.where(row), fmt::format("{} is {}", column, value),
                    fmt::format("give a whole number from {} to {}", low, high));
  return static_cast<int>(value);
}

std::size_t rate_cell(const CsvTable& table, std::size_t row) {
  for (std::size_t i = 0; i < 2; ++i)
    if (table.text(row, "rate") == kRateNames[i]) return i;
  throw FileError(table.where(row), "rate is '" + table.text(row, "rate") + "'",
                  "give half or full");
}

}  // namespace

double QualityPolynomial::operator()(double v, double f, double luminance_cd_m2) const {
  const double l = std::log10(luminance_cd_m2);
  const auto terms = motion_terms(v, f);
  double motion = 0;
  for (std::size_t i = 0; i < terms.size(); ++i) motion += w[i] * terms[i];
  return motion * (w[6] * l * l * l + w[7] * l * l + w[8] * l + w[9]);
}

PolynomialTable PolynomialTable::read(const std::filesystem::path& path) {
  constexpr int kMaxMaterials = 100'000;
  const CsvTable table = CsvTable::read(path);
  int count = 0;
  for (std::size_t row = 0; row < table.rows(); ++row)
    count = std::max(count, index_cell(table, row, "material_index", 1, kMaxMaterials));
  // Before memory is taken for indices that the file cannot fill.
  const std::size_t rows_expected = static_cast<std::size_t>(count) * kMipRows * 2;
  if (count == 0 || table.rows() < rows_expected)
    throw FileError(path,
                    fmt::format("has {} rows for {} materials of {} mip levels and 2 rates",
                                table.rows(), count, kMipRows),
                    fmt::format("give {} rows, one for each combination", rows_expected));

  PolynomialTable out{std::vector<Material>(static_cast<std::size_t>(count))};
  std::vector<bool> seen(rows_expected, false);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const int material = index_cell(table, row, "material_index", 1, count) - 1;
    const int mip = index_cell(table, row, "mip_index_1based", 1, kMipRows) - 1;
    const std::size_t rate = rate_cell(table, row);
    const std::size_t place = (static_cast<std::size_t>(material) * kMipRows + mip) * 2 + rate;
    if (seen[place])
      throw FileError(table.where(row), "repeats a material, mip level and rate",
                      "give each combination once");
    seen[place] = true;
    out.materials_[material].name = table.text(row, "material_name");
    QualityPolynomial& polynomial = out.materials_[material].mips[mip][rate];
    for (std::size_t i = 0; i < polynomial.w.size(); ++i)
      polynomial.w[i] = table.finite_number(row, fmt::format("W{}", i));
  }
  return out;  // as many rows as places and none twice: every place is filled
}

void PolynomialTable::write(const std::filesystem::path& path) const {
  CsvTable table({"material_index", "material_name", "rate", "mip_index_1based", "W0", "W1", "W2",
                  "W3", "W4", "W5", "W6", "W7", "W8", "W9"});
  for (int material = 0; material < materials(); ++material)
    for (std::size_t rate = 0; rate < 2; ++rate)
      for (int mip = 0; mip < kMipRows; ++mip) {
        std::vector<std::string> cells = {std::to_string(material + 1), materials_[material].name,
                                          kRateNames[rate], std::to_string(mip + 1)};
        for (const double w : materials_[material].mips[mip][rate].w)
          cells.push_back(fmt::format("{}", w));
        table.add_row(std::move(cells));
      }
  table.write(path);
}

const PolynomialTable::MipRow& PolynomialTable::at(int material, int mip_level) const {
  return materials_.at(static_cast<std::size_t>(material))
      .mips[static_cast<std::size_t>(std::clamp(mip_level, 0, kMipRows - 1))];
}

QualityPolynomial fit_quality_polynomial(std::span<const QualitySample> samples) {
  std::map<std::array<double, 3>, double> gain;  // by refresh rate, speed, log10 luminance
  for (const QualitySample& s : samples)
    gain[{s.refresh_hz, s.speed_deg_per_s, s.log10_luminance}] = s.gain < kNoGain ? 0 : s.gain;
  const auto at = [&](double f, double v, double l) {
    const auto found = gain.find({f, v, l});
    if (found == gain.end() || !std::isfinite(found->second))
      throw ArgumentError(
          fmt::format("there is no finite sample at {} Hz, {} deg/s, log10 luminance {}", f, v, l),
          "sample the whole grid");
    return found->second;
  };

  constexpr double kTopLuminance = kFitLog10Luminance.back();
  QualityPolynomial out;
  Eigen::Matrix<double, kFitRefresh_hz.size() * kFitSpeed_deg_per_s.size(), 6> terms;
  Eigen::Matrix<double, decltype(terms)::RowsAtCompileTime, 1> gains;
  Eigen::Index row = 0;
  for (const double f : kFitRefresh_hz)
    for (const double v : kFitSpeed_deg_per_s) {
      const auto t = motion_terms(v, f);
      terms.row(row) = Eigen::Map<const Eigen::RowVector<double, 6>>(t.data());
      gains[row++] = at(f, v, kTopLuminance);
    }
  const double reference = at(kLuminanceRefresh_hz, 0, kTopLuminance);
  Eigen::Matrix4d powers;
  Eigen::Vector4d ratios;
  for (int i = 0; i < 4; ++i) {
    const double l = kFitLog10Luminance[i];
    powers.row(i) << l * l * l, l * l, l, 1;
    ratios[i] = at(kLuminanceRefresh_hz, 0, l) / reference;
  }
  if (!(reference > 0)) return out;
  Eigen::Map<Eigen::Vector<double, 6>>(out.w.data()) = terms.colPivHouseholderQr().solve(gains);
  Eigen::Map<Eigen::Vector4d>(out.w.data() + 6) = powers.fullPivLu().solve(ratios);
  return out;
}

std::array<std::vector<QualitySample>, 2> sample_quality_gains(const Camojab& camojab,
                                                               double mip_level) {
  constexpr double kRates[] = {1.0 / 4, 1.0 / 2, 1};
  std::vector<CamojabConditions> conditions;
  for (const double f : kFitRefresh_hz)
    for (const double v : kFitSpeed_deg_per_s)
      for (const double l : kFitLog10Luminance)
        for (const double rate : kRates)
          conditions.push_back({60, f, v, 1, std::pow(10, l), mip_level, rate, rate});
  const std::vector<CamojabQuality> results = camojab.evaluate(conditions);
  std::array<std::vector<QualitySample>, 2> out;
  for (std::size_t i = 0; i < results.size(); i += 3)
    for (std::size_t rate = 0; rate < 2; ++rate) {
      const CamojabConditions& c = conditions[i];
      const double gain = results[i + 1 + rate].quality - results[i].quality;
      out[rate].push_back({c.refresh_hz, c.speed_deg_per_s,
                           kFitLog10Luminance[i / 3 % kFitLog10Luminance.size()],
                           gain < kNoGain ? 0 : gain});
    }
  return out;
}

}  // namespace wheatstone
