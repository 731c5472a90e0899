#include "apps/camera_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "apps/calibration_document.h"
#include "apps/found_boards.h"
#include "calib/camera_uncertainty.h"
#include "capture/import/camera_files.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "core/text.h"
#include "rendering/metrics/false_colour.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMinForCrossValidation = 5;
constexpr double kLeastTopPx = 0.25;  // full scale of uncertainty.png

/// Corners of all boards over the picture's frame, a colour per board, outliers crossed; a line
/// below says what there is.
cv::Mat3b coverage_picture(const FoundBoards& boards, const std::vector<std::size_t>& outliers) {
  cv::Mat3b picture(boards.height_px, boards.width_px, cv::Vec3b(255, 255, 255));
  const int size = std::max(2, boards.width_px / 250), line = std::max(1, size / 2);
  std::size_t corners = 0;
  for (std::size_t v = 0; v < boards.views.size(); ++v) {
    corners += boards.views[v].corners_px.size();
    cv::Mat3b colour(
        1, 1, cv::Vec3b(static_cast<unsigned char>(v * 180 / boards.views.size()), 200, 200));
    cv::cvtColor(colour, colour, cv::COLOR_HSV2RGB);
    const bool outlier = std::find(outliers.begin(), outliers.end(), v) != outliers.end();
    for (const Eigen::Vector2d& p : boards.views[v].corners_px)
      cv::drawMarker(picture, cv::Point(cv::Point2d(p.x(), p.y())), cv::Scalar(colour(0, 0)),
                     outlier ? cv::MARKER_TILTED_CROSS : cv::MARKER_SQUARE, 2 * size, line);
  }
  const cv::Scalar grey(90, 90, 90);
  cv::rectangle(picture, cv::Rect(0, 0, picture.cols, picture.rows), grey, line);
  const double scale = std::max(0.3, picture.cols / 1600.0);
  const int below = static_cast<int>(40 * scale);
  cv::copyMakeBorder(picture, picture, 0, below, 0, 0, cv::BORDER_CONSTANT, cv::Scalar::all(255));
  cv::putText(
      picture,
      fmt::format("{} corners of {}, a colour each; crosses: {}", corners,
                  counted(boards.views.size(), "board"), counted(outliers.size(), "outlier board")),
      {below / 4, picture.rows - below / 3}, cv::FONT_HERSHEY_SIMPLEX, scale, grey, line,
      cv::LINE_AA);
  return picture;
}

/// The first of 0.25, 0.5, 1, 2.5, 5, 10, 25, ... that 95 % of the map do not exceed.
double round_top(const ScalarImage& map) {
  std::vector<float> values;
  for (const float v : map.pixels)
    if (!std::isnan(v)) values.push_back(v);
  if (values.empty()) return kLeastTopPx;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.95 * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  double top = kLeastTopPx;
  for (int step = 0; top < *at && step < 30; ++step) top *= step % 3 == 2 ? 2.5 : 2;
  return top;
}

void write_pictures(const fs::path& folder, const CameraCalibration& c, const FoundBoards& boards,
                    const std::vector<std::size_t>& outliers) {
  write_picture_png(folder / "coverage.png", coverage_picture(boards, outliers));
  ScalarImage map = projection_uncertainty_px(c);
  write_exr(folder / "uncertainty.exr", map, "sigma_px");
  const double top_px = round_top(map);
  cv::patchNaNs(map.pixels, top_px);
  write_picture_png(folder / "uncertainty.png",
                    false_colour_difference(map, top_px, "px standard deviation"));
}

double largest(const ScalarImage& map) {
  double top = 0;
  for (const float v : map.pixels)
    if (v > top) top = v;  // false for NaN
  return top;
}

}  // namespace

json calibrate_camera(const CameraCalibrationOptions& options, const Progress& progress) {
  FoundBoards boards =
      find_boards(options.images, options.match, options.board, options.charuco, progress);
  const auto solve = [&] {
    return solve_camera(boards.views, options.board, boards.width_px, boards.height_px,
                        options.model);
  };
  CameraCalibration c = solve();
  std::vector<std::size_t> outliers = outlier_boards(c);
  std::vector<std::string> left_out;
  if (options.without_outliers && !outliers.empty()) {
    for (auto v = outliers.rbegin(); v != outliers.rend(); ++v) {
      left_out.push_back(boards.views[*v].name);
      boards.views.erase(boards.views.begin() + static_cast<std::ptrdiff_t>(*v));
    }
    c = solve();
    outliers = outlier_boards(c);
  }

  json document = camera_json(c);
  document["board"] = board_json(options.board);
  if (options.charuco) {
    document["board"]["dictionary"] = options.charuco->dictionary;
    document["board"]["marker_mm"] = options.charuco->marker_mm;
  }
  document["pictures_without_board"] = boards.without_board;
  document["larger_board"] = boards.larger_board;
  document["left_out"] = left_out;
  std::vector<double> held_out;
  document["cross_validation_rms_px"] = nullptr;
  if (boards.views.size() >= kMinForCrossValidation) {
    held_out = cross_validate(boards.views, options.board, boards.width_px, boards.height_px,
                              options.model);
    double squares = 0;
    for (const double r : held_out) squares += r * r;
    document["cross_validation_rms_px"] = std::sqrt(squares / static_cast<double>(held_out.size()));
  }
  json list = json::array();
  for (std::size_t v = 0; v < boards.views.size(); ++v) {
    json entry = transform_json(c.T_camera_board[v]);
    entry["file"] = boards.views[v].name;
    entry["corners"] = boards.views[v].corners_px.size();
    entry["rms_px"] = c.board_rms_px[v];
    entry["held_out_rms_px"] = held_out.empty() ? json(nullptr) : json(held_out[v]);
    entry["outlier"] = std::find(outliers.begin(), outliers.end(), v) != outliers.end();
    list.push_back(std::move(entry));
  }
  document["boards"] = list;
  document["uncertainty_mean_px"] = mean_uncertainty_px(c);
  document["uncertainty_largest_px"] = largest(projection_uncertainty_px(c));
  document["advice"] = next_board(c, options.board).text;

  json written = json::array();
  if (options.out) {
    make_folder(*options.out);
    const CameraFile camera{c.intrinsics, c.distortion};
    for (const auto& [format, name] : {std::pair(CameraFormat::kOpenCv, "camera.yaml"),
                                       {CameraFormat::kColmap, "cameras.txt"},
                                       {CameraFormat::kKalibr, "camchain.yaml"}}) {
      const std::string reason = why_not_exact(format, camera);
      if (reason.empty()) write_camera_file(*options.out / name, format, {camera});
      written.push_back({{"file", name}, {"not_written", reason.empty() ? json() : json(reason)}});
    }
    write_pictures(*options.out, c, boards, outliers);
  }
  document["camera_files"] = written;
  if (options.out)
    write_json(*options.out / "calibration.json", "wheatstone-camera-calibration/1", document);
  return document;
}

}  // namespace wheatstone::apps
