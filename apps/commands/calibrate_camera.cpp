#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/camera_calibration.h"
#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stereo_calibration.h"
#include "capture/import/camera_files.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

using nlohmann::json;

/// What both calibrations ask for.
struct BoardArguments {
  std::string images, board, distortion = "radtan5", out;
  double square_mm = 0;
  bool as_json = false;

  void add_to(CLI::App& command) {
    command.add_option("--images", images, "folder of pictures")->required();
    command.add_option("--board", board, "inner corners per row and column, as in 9x6")->required();
    command.add_option("--square-mm", square_mm, "side of a square in mm")->required();
    command.add_option("--distortion", distortion, "radtan4, radtan5, radtan8 or fisheye")
        ->capture_default_str();
    command.add_option("--out", out, "folder for camera files, pictures and the result as JSON");
    command.add_flag("--json", as_json, "the result as JSON on standard output");
  }
  Board parsed_board() const {
    if (square_mm > 0 && square_mm < 1)
      fmt::print(stderr, "warning: squares of {} mm: --square-mm takes millimetres, not metres\n",
                 square_mm);
    return board_from_string(board, square_mm);
  }
  std::optional<std::filesystem::path> out_folder() const {
    return out.empty() ? std::nullopt : std::optional<std::filesystem::path>(out);
  }
};

void warn_of_larger_boards(const json& document) {
  const json& pictures = document.at("larger_board");
  if (pictures.empty()) return;
  fmt::print(
      stderr,
      "warning: in {} the chessboard goes on beyond the {}x{} inner corners of --board, as in "
      "{}; count them again: of a larger board any part is found, so that board poses do not "
      "agree between pictures and the calibration is less exact\n",
      counted(pictures.size(), "picture"), document["board"]["columns"].get<int>(),
      document["board"]["rows"].get<int>(), pictures[0].get<std::string>());
}

void print_camera(const json& c) {
  const auto value = [&](const char* key) { return c.at(key).get<double>(); };
  for (const char* key : {"fx_px", "fy_px", "cx_px", "cy_px"})
    fmt::print("{:<6} {:12.4f} +- {:.4f}\n", key, value(key),
               value((std::string(key) + "_sigma").c_str()));
  for (std::size_t i = 0; i < c.at("distortion").size(); ++i)
    fmt::print("{:<6} {:12.6f} +- {:.6f}\n", c["distortion_names"][i].get<std::string>(),
               c["distortion"][i].get<double>(), c["distortion_sigma"][i].get<double>());
  const json& loose = c.at("loose_coefficients");
  if (loose.empty()) return;
  std::string names;
  for (const json& name : loose) names += (names.empty() ? "" : ", ") + name.get<std::string>();
  fmt::print(
      "not determined one by one: {}; use a --distortion with fewer terms, unless its "
      "cross-validated RMS is clearly larger\n",
      names);
}

/// The camera files, and what else was written with them; nothing where nothing was.
void print_files(const json& c, const char* others) {
  for (const json& f : c["camera_files"])
    if (f["not_written"].is_null())
      fmt::print("wrote {}\n", f["file"].get<std::string>());
    else
      fmt::print("for information: no {}, because {}\n", f["file"].get<std::string>(),
                 f["not_written"].get<std::string>());
  if (!c["camera_files"].empty()) fmt::print("wrote {}\n", others);
}

void print_calibration(const json& c) {
  print_camera(c);
  fmt::print("RMS {:.4f} px over {}", c["rms_px"].get<double>(),
             counted(c["boards"].size(), "board"));
  if (!c["cross_validation_rms_px"].is_null())
    fmt::print(", {:.4f} px cross-validated", c["cross_validation_rms_px"].get<double>());
  fmt::print("\n");
  for (const json& name : c["pictures_without_board"])
    fmt::print("no board in {}\n", name.get<std::string>());
  for (const json& name : c["left_out"]) fmt::print("left out: {}\n", name.get<std::string>());
  for (const json& b : c["boards"])
    if (b["outlier"].get<bool>())
      fmt::print("outlier: {} (RMS {:.3f} px): moved, bent or misfound? --without-outliers\n",
                 b["file"].get<std::string>(), b["rms_px"].get<double>());
  fmt::print("projection uncertainty {:.3f} px RMS over the picture, {:.3f} px at most\n",
             c["uncertainty_mean_px"].get<double>(), c["uncertainty_largest_px"].get<double>());
  fmt::print("next: {}\n", c["advice"].get<std::string>());
  print_files(c, "coverage.png, uncertainty.png, uncertainty.exr and calibration.json");
}

}  // namespace

void add_calibrate_camera(CLI::App& calibrate) {
  auto* command = calibrate.add_subcommand(
      "camera", "Intrinsics and lens distortion from pictures of a chessboard or ChArUco board");
  auto common = std::make_shared<BoardArguments>();
  auto markers = std::make_shared<CharucoMarkers>();
  auto options = std::make_shared<CameraCalibrationOptions>();
  common->add_to(*command);
  command->add_option("--match", options->match, "pictures to use, as in 'left*.jpg'")
      ->capture_default_str();
  command->add_flag("--without-outliers", options->without_outliers,
                    "leave out boards that fit 3 times worse than the median");
  auto* charuco = command->add_option("--charuco", markers->dictionary,
                                      "the board is a ChArUco board with markers of this "
                                      "dictionary, as in DICT_4X4_50");
  charuco->needs(command->add_option("--marker-mm", markers->marker_mm, "side of a marker in mm")
                     ->needs(charuco));
  command->footer(
      "Example:\n  wheatstone calibrate camera --images ../shared/data/camera_calibration/"
      "opencv_9x6 --match 'left*' --board 9x6 --square-mm 25 --out out/left");
  command->callback([=] {
    options->images = common->images;
    options->board = common->parsed_board();
    if (!markers->dictionary.empty()) options->charuco = *markers;
    options->model = distortion_model_from_string(common->distortion);
    options->out = common->out_folder();
    const json result = calibrate_camera(*options, show_progress);
    warn_of_larger_boards(result);
    if (common->as_json)
      fmt::print("{}\n", result.dump(2));
    else
      print_calibration(result);
  });
}

void add_calibrate_stereo(CLI::App& calibrate) {
  auto* command = calibrate.add_subcommand(
      "stereo", "Two cameras, and where one stands from the other, from boards both see");
  auto common = std::make_shared<BoardArguments>();
  auto options = std::make_shared<StereoCalibrationOptions>();
  common->add_to(*command);
  command->add_option("--left", options->left, "the left camera's pictures, as in 'left*'")
      ->required();
  command->add_option("--right", options->right, "the right camera's pictures, as in 'right*'")
      ->required();
  command->footer(
      "Example:\n  wheatstone calibrate stereo --images ../shared/data/camera_calibration/"
      "bumblebee2_chess --left 'left*' --right 'right*' --board 4x6 --square-mm 30");
  command->callback([=] {
    options->images = common->images;
    options->board = common->parsed_board();
    options->model = distortion_model_from_string(common->distortion);
    options->out = common->out_folder();
    const json result = calibrate_stereo(*options, show_progress);
    warn_of_larger_boards(result);
    if (common->as_json) {
      fmt::print("{}\n", result.dump(2));
      return;
    }
    for (const char* side : {"left", "right"}) {
      fmt::print("{}\n", side);
      print_camera(result[side]);
    }
    fmt::print("RMS {:.4f} px over {}\nbaseline {:.3f} +- {:.3f} mm\n",
               result["rms_px"].get<double>(), counted(result["pairs"].size(), "pair"),
               result["baseline_mm"].get<double>(), result["baseline_mm_sigma"].get<double>());
    for (const json& picture : result["unpaired"])
      fmt::print("without its other half: {} ({})\n", picture["file"].get<std::string>(),
                 picture["reason"].get<std::string>());
    print_files(result, "stereo.json");
  });
}

void add_convert_camera(CLI::App& app) {
  auto* command = app.add_subcommand("convert-camera",
                                     "A camera file of OpenCV, COLMAP or Kalibr into another's");
  auto input = std::make_shared<std::string>();
  auto format = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command->add_option("input", *input, "OpenCV or Kalibr .yaml, COLMAP cameras.txt")->required();
  command->add_option("--format", *format, "opencv, colmap or kalibr")->required();
  command->add_option("--out", *out, "new file")->required();
  command->footer(
      "Example:\n  wheatstone convert-camera out/left/camera.yaml --format colmap "
      "--out out/cameras.txt");
  command->callback([=] {
    require_other_file(*out, {*input});
    write_camera_file(*out, camera_format_from_string(*format), read_camera_file(*input));
    fmt::print("wrote {}\n", *out);
  });
}

}  // namespace wheatstone::apps
