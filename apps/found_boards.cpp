#include "apps/found_boards.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/error.h"
#include "core/png.h"
#include "core/text.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;

namespace {

bool is_picture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp"})
    if (ending == known) return true;
  return false;
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
  throw FileError(folder,
                  fmt::format("shows no {} corners of a board with markers of {} in {}",
                              kMinCorners, markers.dictionary, counted(files.size(), "picture")),
                  seen.empty() || seen == markers.dictionary
                      ? "the markers must be sharp and evenly lit"
                      : fmt::format("{} holds markers of {}", files[0].string(), seen));
}

}  // namespace

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
    if (auto view = view_of(grey, folder, files[i], board, markers)) {
      if (!markers && goes_on_beyond(grey, board, view->corners_px))
        found.larger_board.push_back(view->name);
      found.views.push_back(std::move(*view));
    } else {
      found.without_board.push_back(files[i].string());
    }
    progress("find boards", static_cast<int>(i) + 1, static_cast<int>(files.size()));
  }
  if (found.views.empty() && markers) throw_no_charuco(folder, files, *markers);
  if (found.views.empty())
    throw FileError(folder,
                    fmt::format("shows no board of {}x{} inner corners in {}", board.columns,
                                board.rows, counted(files.size(), "picture")),
                    "count the inner corners, not the squares, for --board; the whole board must "
                    "be in the picture, sharp and evenly lit");
  return found;
}

}  // namespace wheatstone::apps
