#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/commands/commands.h"
#include "calib/led_array_calibration.h"
#include "core/csv.h"
#include "core/error.h"
#include "core/json.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "wheatstone-leds/2";
constexpr std::size_t kLeds = std::size_t{kLedRows} * kLedColumns;

/// The readings of one LED while they come in.
struct Readings {
  std::array<std::optional<Eigen::Vector3d>, 3> full;
  std::optional<Eigen::Vector3d> off;
  std::array<std::vector<DriveReading>, 3> sweeps;
};

int whole(const CsvTable& table, std::size_t row, const char* column, int limit) {
  const double value = table.finite_number(row, column);
  if (value != std::round(value) || value < 0 || value >= limit)
    throw ArgumentError(
        table.where(row) + ": " + column + " is no whole number below " + std::to_string(limit),
        "count rows and columns from 0");
  return static_cast<int>(value);
}

constexpr double kDoubtfulResidual = 0.1;
constexpr double kDarkOfFull = 0.01;  // below this share of full drive residuals are not relative

/// The reading that the fitted responses miss most, relative to it.
struct LargestResidual {
  double relative = 0;
  std::string where;
};

LargestResidual largest_residual(const std::vector<LedCalibration>& leds,
                                 const std::vector<Readings>& readings) {
  LargestResidual largest;
  for (std::size_t led = 0; led < leds.size(); ++led)
    for (std::size_t c = 0; c < 3; ++c) {
      const GainGammaOffset& response = leds[led].responses[c];
      const double floor = kDarkOfFull * response.luminance_cd_m2(1);
      for (const DriveReading& r : readings[led].sweeps[c]) {
        const double relative = (response.luminance_cd_m2(r.drive) - r.luminance_cd_m2) /
                                std::max(r.luminance_cd_m2, floor);
        if (std::abs(relative) > std::abs(largest.relative))
          largest = {relative, fmt::format("row {}, column {}, {} at drive {}", led / kLedColumns,
                                           led % kLedColumns, "RGB"[c], r.drive)};
      }
    }
  return largest;
}

std::vector<Readings> read_readings(const CsvTable& table) {
  std::vector<Readings> readings(kLeds);
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto led = static_cast<std::size_t>(whole(table, i, "row", kLedRows) * kLedColumns +
                                              whole(table, i, "column", kLedColumns));
    const Eigen::Vector3d xyz(table.finite_number(i, "X_cd_m2"), table.finite_number(i, "Y_cd_m2"),
                              table.finite_number(i, "Z_cd_m2"));
    const double drive = table.finite_number(i, "drive");
    if (drive < 0 || drive > 1)
      throw ArgumentError(table.where(i) + fmt::format(": a drive of {}; drive is 0 to 1", drive),
                          "divide the drives by full drive, as by 100 or 255");
    const std::string emitter = table.text(i, "emitter");
    const std::size_t channel = std::string("RGB").find(emitter);
    if (emitter == "off") {
      readings[led].off = xyz;
    } else if (emitter.size() == 1 && channel < 3) {
      readings[led].sweeps[channel].push_back({drive, xyz.y()});
      if (drive == 1) readings[led].full[channel] = xyz;
    } else {
      throw ArgumentError(table.where(i) + ": there is no emitter " + emitter,
                          "use R, G, B or off");
    }
  }
  return readings;
}

std::vector<LedCalibration> calibrate(const std::vector<Readings>& readings) {
  std::vector<LedCalibration> leds;
  for (std::size_t led = 0; led < kLeds; ++led) {
    const Readings& r = readings[led];
    const auto where =
        fmt::format("the LED in row {}, column {}", led / kLedColumns, led % kLedColumns);
    if (!r.off || !r.full[0] || !r.full[1] || !r.full[2])
      throw ArgumentError(
          where + " lacks a reading with all off, or one at full drive of R, G or B",
          "measure every LED: off, and each emitter alone up to drive 1");
    try {
      leds.push_back(calibrate_led({*r.full[0], *r.full[1], *r.full[2]}, *r.off, r.sweeps));
    } catch (const ArgumentError& e) {
      throw ArgumentError(where + ": " + e.what(), "");
    }
  }
  return leds;
}

json to_json(const LedCalibration& led) {
  json responses = json::array();
  for (const GainGammaOffset& r : led.responses)
    responses.push_back({{"span_cd_m2", r.span_cd_m2},
                         {"offset", r.offset},
                         {"gamma", r.gamma},
                         {"black_cd_m2", r.black_cd_m2}});
  return {{"xyz_cd_m2", wheatstone::to_json(Eigen::MatrixXd(led.xyz_cd_m2))},
          {"off_xyz_cd_m2", wheatstone::to_json(led.off_xyz_cd_m2)},
          {"responses", responses}};
}

std::vector<LedCalibration> read_leds(const std::filesystem::path& file) {
  const json document = read_json(file, kSchema);
  const auto list = json_get<std::vector<json>>(document, "leds", file);
  if (list.size() != kLeds) throw_bad_key(file, "leds", fmt::format("must have {} entries", kLeds));
  std::vector<LedCalibration> leds;
  for (const json& entry : list) {
    LedCalibration led;
    led.xyz_cd_m2 =
        matrix_from_json(json_get<json>(entry, "xyz_cd_m2", file), 3, 3, file, "xyz_cd_m2");
    led.off_xyz_cd_m2 =
        vector3_from_json(json_get<json>(entry, "off_xyz_cd_m2", file), file, "off_xyz_cd_m2");
    const auto responses = json_get<std::vector<json>>(entry, "responses", file);
    if (responses.size() != 3) throw_bad_key(file, "responses", "must have 3 entries");
    for (std::size_t c = 0; c < 3; ++c)
      led.responses[c] = {json_get<double>(responses[c], "span_cd_m2", file),
                          json_get<double>(responses[c], "offset", file),
                          json_get<double>(responses[c], "gamma", file),
                          json_get<double>(responses[c], "black_cd_m2", file)};
    leds.push_back(led);
  }
  return leds;
}

void write_drives(const std::string& out, const std::vector<LedDrive>& drives) {
  CsvTable table({"row", "column", "drive_r", "drive_g", "drive_b"});
  for (std::size_t led = 0; led < drives.size(); ++led)
    table.add_row({std::to_string(led / kLedColumns), std::to_string(led % kLedColumns),
                   fmt::format("{}", drives[led][0]), fmt::format("{}", drives[led][1]),
                   fmt::format("{}", drives[led][2])});
  table.write(out);
}

}  // namespace

void add_calibrate_leds(CLI::App& calibrate_app) {
  auto* command = calibrate_app.add_subcommand(
      "leds", "The LED ceiling: colours and response of every LED, from measurements");
  auto readings = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command->add_option("--readings", *readings, "CSV (docs/led_array.md)")->required();
  command->add_option("--out", *out, "JSON with the calibration")->required();
  command->footer("Example:\n  wheatstone calibrate leds --readings ceiling.csv --out leds.json");
  command->callback([=] {
    const std::vector<Readings> seen = read_readings(CsvTable::read(*readings));
    const std::vector<LedCalibration> leds = calibrate(seen);
    json list = json::array();
    for (const LedCalibration& led : leds) list.push_back(to_json(led));
    write_json(*out, kSchema, {{"rows", kLedRows}, {"columns", kLedColumns}, {"leds", list}});
    const LargestResidual worst = largest_residual(leds, seen);
    if (worst.where.empty())
      fmt::print("{} in {}\n", counted(leds.size(), "LED"), *out);
    else
      fmt::print("{} in {}; largest residual {:+.2g} % ({})\n", counted(leds.size(), "LED"), *out,
                 100 * worst.relative, worst.where);
    if (std::abs(worst.relative) > kDoubtfulResidual)
      fmt::print(stderr,
                 "warning: the fitted response misses a reading by {:.0f} %; measure {} again\n",
                 100 * std::abs(worst.relative), worst.where);
  });
}

void add_leds(CLI::App& app) {
  auto* command = app.add_subcommand(
      "leds", "Which drives light the box with a stated luminance and chromaticity");
  auto file = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto luminance = std::make_shared<double>(0);
  auto xy = std::make_shared<std::vector<double>>();
  command->add_option("--calibration", *file, "JSON of calibrate leds")->required();
  command->add_option("--luminance", *luminance, "of every LED, cd/m², above 0")->required();
  command->add_option("--xy", *xy, "CIE 1931 chromaticity")->required()->expected(2);
  command->add_option("--out", *out, "CSV: row, column, drive_r, drive_g, drive_b")->required();
  command->footer(
      "Example:\n  wheatstone leds --calibration leds.json --luminance 400 --xy 0.3127 0.3290 "
      "--out "
      "drives.csv");
  command->callback([=] {
    if (!(*luminance > 0))
      throw ArgumentError(fmt::format("--luminance is {}", *luminance), "give cd/m² above 0");
    const std::vector<LedDrive> drives =
        led_drives(read_leds(*file), *luminance, {xy->at(0), xy->at(1)});
    write_drives(*out, drives);
    fmt::print("drives of {} in {}\n", counted(drives.size(), "LED"), *out);
  });
}

}  // namespace wheatstone::apps
