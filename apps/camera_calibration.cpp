#include "apps/camera_calibration.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <opencv2/imgproc.hpp>

#include "apps/report.h"
#include "calib/camera_uncertainty.h"
#include "calib/stereo_solver.h"
#include "capture/import/camera_files.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "rendering/metrics/false_colour.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMinForCrossValidation = 5;
constexpr double kLeastTopPx = 0.25;  // full scale of uncertainty.png

bool is_picture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp"})
    if (ending == known) return true;
  return false;
}

std::vector<fs::path> pictures_below(const fs::path& folder, const std::string& match) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    const fs::path relative = it->path().lexically_relative(folder);
    if (it->is_regular_file() && is_picture(relative) &&
        fnmatch(match.c_str(), relative.c_str(), FNM_PATHNAME | FNM_PERIOD) == 0)
      files.push_back(relative);
  }
  if (error)
    throw FileError(folder, "cannot be listed: " + error.message(), "give a folder of pictures");
  if (files.empty())
    throw FileError(folder, "holds no picture that matches '" + match + "'",
                    "give a folder of JPEG, PNG, TIFF or BMP pictures, or another pattern");
  std::sort(files.begin(), files.end());
  return files;
}

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
  cv::putText(picture,
              fmt::format("{} corners of {} boards, a colour each; crosses: {} outlier boards",
                          corners, boards.views.size(), outliers.size()),
              {below / 4, picture.rows - below / 3}, cv::FONT_HERSHEY_SIMPLEX, scale, grey, line,
              cv::LINE_AA);
  return picture;
}

json camera_json(const CameraCalibration& c) {
  const Eigen::VectorXd sigma = c.sigma();
  std::vector<double> distortion_sigma(sigma.data() + 4, sigma.data() + sigma.size());
  return {{"width_px", c.intrinsics.width_px},
          {"height_px", c.intrinsics.height_px},
          {"fx_px", c.intrinsics.fx_px},
          {"fy_px", c.intrinsics.fy_px},
          {"cx_px", c.intrinsics.cx_px},
          {"cy_px", c.intrinsics.cy_px},
          {"fx_px_sigma", sigma[0]},
          {"fy_px_sigma", sigma[1]},
          {"cx_px_sigma", sigma[2]},
          {"cy_px_sigma", sigma[3]},
          {"distortion_model", to_string(c.model)},
          {"distortion_names", coefficient_names(c.model)},
          {"distortion", coefficients(c.distortion, c.model)},
          {"distortion_sigma", distortion_sigma},
          {"loose_coefficients", loose_coefficients(c)},
          {"covariance", to_json(c.covariance)},
          {"rms_px", c.rms_px},
          {"corner_sigma_px", c.corner_sigma_px}};
}

json to_json_transform(const RigidTransform& T) {
  return {{"R", to_json(Eigen::MatrixXd(T.R))}, {"t_mm", to_json(T.t_mm)}};
}

json board_json(const Board& board) {
  return {{"columns", board.columns}, {"rows", board.rows}, {"square_mm", board.square_mm}};
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

bool on_one_line(const BoardView& view, const Board& board) {
  const std::vector<Eigen::Vector3d> points = seen_corners_mm(view, board);
  const Eigen::Vector3d first = points[1] - points[0];
  return std::all_of(points.begin(), points.end(), [&](const Eigen::Vector3d& p) {
    return std::abs(first.cross(p - points[0]).z()) < 1e-6 * board.square_mm * board.square_mm;
  });
}

/// The board in one picture; nothing when too little of it is seen.
std::optional<BoardView> view_of(const cv::Mat1b& grey, const fs::path& folder,
                                 const fs::path& file, const Board& board,
                                 const std::optional<CharucoMarkers>& markers) {
  if (!markers) {
    auto corners = find_board(grey, board);
    if (!corners) return std::nullopt;
    return BoardView{file.string(), std::move(*corners)};
  }
  CharucoSighting seen;
  try {
    seen = find_charuco(grey, board, *markers);
  } catch (const ArgumentError& e) {
    throw FileError(folder / file, e.what(), "");
  }
  BoardView view{file.string(), std::move(seen.corners_px), std::move(seen.corner_ids)};
  if (view.corners_px.size() < kMinCorners || on_one_line(view, board)) return std::nullopt;
  return view;
}

[[noreturn]] void throw_no_charuco(const fs::path& folder, const std::vector<fs::path>& files,
                                   const CharucoMarkers& markers) {
  const std::string seen = dictionary_in(read_grey_picture(folder / files[0]));
  throw FileError(
      folder,
      fmt::format("shows {} corners of a board with markers of {} in none of its {} pictures",
                  kMinCorners, markers.dictionary, files.size()),
      seen.empty() || seen == markers.dictionary
          ? "the markers must be sharp and evenly lit"
          : fmt::format("{} holds markers of {}", files[0].string(), seen));
}

}  // namespace

FoundBoards find_boards(const fs::path& folder, const std::string& match, const Board& board,
                        const std::optional<CharucoMarkers>& markers, const Progress& progress) {
  if (markers) check_charuco(board, *markers);
  const std::vector<fs::path> files = pictures_below(folder, match);
  FoundBoards found;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const cv::Mat1b grey = read_grey_picture(folder / files[i]);
    if (i == 0) found.width_px = grey.cols, found.height_px = grey.rows;
    if (grey.cols != found.width_px || grey.rows != found.height_px)
      throw FileError(folder / files[i],
                      fmt::format("is {}x{} px, but {} is {}x{} px", grey.cols, grey.rows,
                                  files[0].string(), found.width_px, found.height_px),
                      "calibrate each camera and each picture size on its own, choosing the "
                      "pictures with --match");
    if (auto view = view_of(grey, folder, files[i], board, markers))
      found.views.push_back(std::move(*view));
    else
      found.without_board.push_back(files[i].string());
    progress("find boards", static_cast<int>(i) + 1, static_cast<int>(files.size()));
  }
  if (found.views.empty() && markers) throw_no_charuco(folder, files, *markers);
  if (found.views.empty())
    throw FileError(folder,
                    fmt::format("shows a board of {}x{} inner corners in none of its {} pictures",
                                board.columns, board.rows, files.size()),
                    "count the inner corners, not the squares, for --board; the whole board must "
                    "be in the picture, sharp and evenly lit");
  return found;
}

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
    json entry = to_json_transform(c.T_camera_board[v]);
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

namespace {

/// The number at the end of a picture's name; empty without one.
std::string number_of(const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  const auto last = stem.find_last_not_of("0123456789");
  return last == std::string::npos ? stem : stem.substr(last + 1);
}

struct NumberedPicture {
  std::string name;
  const BoardView* board = nullptr;  // none: no board was found in it
};

/// Pictures by the number at the end of their names.
std::map<std::string, NumberedPicture> by_number(const FoundBoards& boards,
                                                 const fs::path& folder) {
  std::map<std::string, NumberedPicture> numbered;
  for (const BoardView& v : boards.views) {
    const std::string number = number_of(v.name);
    if (number.empty())
      throw FileError(folder / v.name, "has no number at the end of its name",
                      "name the two pictures of a pair alike, as in left07.jpg and right07.jpg");
    if (!numbered.emplace(number, NumberedPicture{v.name, &v}).second)
      throw FileError(folder / v.name, "has the same number as " + numbered[number].name,
                      "choose one camera's pictures with --left and --right");
  }
  for (const std::string& name : boards.without_board) {
    const std::string number = number_of(name);
    numbered.emplace(number.empty() || numbered.contains(number) ? name : number,
                     NumberedPicture{name});
  }
  return numbered;
}

/// Pictures of one side that are no half of a pair, each with the reason. A picture without a board
/// whose other half has one is named there.
void add_unpaired(const std::map<std::string, NumberedPicture>& side,
                  const std::map<std::string, NumberedPicture>& others, json& list) {
  for (const auto& [number, picture] : side) {
    const auto other = others.find(number);
    const bool other_has_board = other != others.end() && other->second.board;
    if (picture.board && !other_has_board)
      list.push_back({{"file", picture.name},
                      {"reason", other == others.end() ? "the other side has no picture " + number
                                                       : "no board in " + other->second.name}});
    else if (!picture.board && !other_has_board)
      list.push_back({{"file", picture.name}, {"reason", "no board in it"}});
  }
}

void require_two_sides(const StereoCalibrationOptions& options) {
  const auto left = pictures_below(options.images, options.left);
  const auto right = pictures_below(options.images, options.right);
  std::vector<fs::path> both;
  std::set_intersection(left.begin(), left.end(), right.begin(), right.end(),
                        std::back_inserter(both));
  if (!both.empty())
    throw FileError(options.images / both[0], "is a picture of the left and of the right camera",
                    "choose each camera's own pictures with --left and --right");
}

}  // namespace

json calibrate_stereo(const StereoCalibrationOptions& options, const Progress& progress) {
  require_two_sides(options);
  const FoundBoards left =
      find_boards(options.images, options.left, options.board, std::nullopt, progress);
  const FoundBoards right =
      find_boards(options.images, options.right, options.board, std::nullopt, progress);
  if (left.width_px != right.width_px || left.height_px != right.height_px)
    throw FileError(options.images,
                    fmt::format("holds left pictures of {}x{} and right ones of {}x{} px",
                                left.width_px, left.height_px, right.width_px, right.height_px),
                    "use two cameras of one size");
  const auto left_views = by_number(left, options.images);
  const auto right_views = by_number(right, options.images);
  std::vector<BoardView> paired_left, paired_right;
  for (const auto& [number, picture] : left_views)
    if (const auto other = right_views.find(number);
        picture.board && other != right_views.end() && other->second.board) {
      paired_left.push_back(*picture.board);
      paired_right.push_back(*other->second.board);
    }
  json unpaired = json::array();
  add_unpaired(left_views, right_views, unpaired);
  add_unpaired(right_views, left_views, unpaired);
  if (paired_left.size() < 3)
    throw FileError(options.images,
                    fmt::format("shows the board to both cameras in {} pairs; 3 are needed",
                                paired_left.size()),
                    "take more pairs, and check --left and --right");

  const StereoCalibration s = solve_stereo(paired_left, paired_right, options.board, left.width_px,
                                           left.height_px, options.model);
  json pairs = json::array();
  for (std::size_t i = 0; i < paired_left.size(); ++i)
    pairs.push_back({{"left", paired_left[i].name},
                     {"right", paired_right[i].name},
                     {"left_rms_px", s.left.board_rms_px[i]},
                     {"right_rms_px", s.right.board_rms_px[i]}});
  json document = {
      {"left", camera_json(s.left)},
      {"right", camera_json(s.right)},
      {"T_right_left", to_json_transform(s.T_right_left)},
      {"T_right_left_covariance_rad_mm", to_json(Eigen::MatrixXd(s.T_right_left_covariance))},
      {"baseline_mm", s.baseline_mm},
      {"baseline_mm_sigma", s.baseline_sigma_mm},
      {"rms_px", s.rms_px},
      {"board", board_json(options.board)},
      {"pairs", pairs},
      {"unpaired", unpaired}};
  json written = json::array();
  if (options.out) {
    make_folder(*options.out);
    const std::vector<CameraFile> cameras = {{s.left.intrinsics, s.left.distortion},
                                             {s.right.intrinsics, s.right.distortion}};
    write_camera_file(*options.out / "left.yaml", CameraFormat::kOpenCv, {cameras[0]});
    write_camera_file(*options.out / "right.yaml", CameraFormat::kOpenCv, {cameras[1]});
    std::string reason = why_not_exact(CameraFormat::kKalibr, cameras[0]);
    if (reason.empty()) reason = why_not_exact(CameraFormat::kKalibr, cameras[1]);
    if (reason.empty())
      write_camera_file(*options.out / "camchain.yaml", CameraFormat::kKalibr, cameras,
                        s.T_right_left);
    written = {
        {{"file", "left.yaml"}, {"not_written", nullptr}},
        {{"file", "right.yaml"}, {"not_written", nullptr}},
        {{"file", "camchain.yaml"}, {"not_written", reason.empty() ? json() : json(reason)}}};
  }
  document["camera_files"] = written;
  if (options.out)
    write_json(*options.out / "stereo.json", "wheatstone-stereo-calibration/1", document);
  return document;
}

}  // namespace wheatstone::apps
