#include "apps/stereo_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "apps/calibration_document.h"
#include "apps/found_boards.h"
#include "calib/stereo_solver.h"
#include "capture/import/camera_files.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

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
                    fmt::format("shows the board to both cameras in {}; 3 are needed",
                                counted(paired_left.size(), "pair")),
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
      {"T_right_left", transform_json(s.T_right_left)},
      {"T_right_left_covariance_rad_mm", to_json(Eigen::MatrixXd(s.T_right_left_covariance))},
      {"baseline_mm", s.baseline_mm},
      {"baseline_mm_sigma", s.baseline_sigma_mm},
      {"rms_px", s.rms_px},
      {"board", board_json(options.board)},
      {"pairs", pairs},
      {"unpaired", unpaired}};
  document["larger_board"] = left.larger_board;
  for (const std::string& name : right.larger_board) document["larger_board"].push_back(name);
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
