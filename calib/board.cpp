#include "calib/board.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

// cornerSubPix fails where its window reaches the next corner, and gains nothing beyond 11 px.
constexpr double kWindowOfSpacing = 0.4;
constexpr int kLargestWindowPx = 11;

double smallest_spacing_px(const std::vector<cv::Point2f>& corners, const Board& board) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int r = 0; r < board.rows; ++r)
    for (int c = 0; c < board.columns; ++c) {
      const auto& p = corners[static_cast<std::size_t>(r * board.columns + c)];
      const auto at = [&](int i) { return corners[static_cast<std::size_t>(i)]; };
      if (c > 0) smallest = std::min(smallest, cv::norm(p - at(r * board.columns + c - 1)));
      if (r > 0) smallest = std::min(smallest, cv::norm(p - at((r - 1) * board.columns + c)));
    }
  return smallest;
}

}  // namespace

Board board_from_string(const std::string& text, double square_mm) {
  Board board{0, 0, square_mm};
  const char* const end = text.data() + text.size();
  const auto columns = std::from_chars(text.data(), end, board.columns);
  if (columns.ec == std::errc() && columns.ptr != end && *columns.ptr == 'x') {
    const auto rows = std::from_chars(columns.ptr + 1, end, board.rows);
    if (rows.ec != std::errc() || rows.ptr != end) board.rows = 0;
  }
  if (board.columns < 3 || board.rows < 3 || board.columns > 100 || board.rows > 100)
    throw ArgumentError("'" + text + "' is no chessboard",
                        "give the inner corners per row and column, each 3 to 100, as in 9x6");
  if (!(square_mm > 0) || !std::isfinite(square_mm))
    throw ArgumentError("a board's squares must have a side above 0 mm",
                        "measure them, for example --square-mm 25");
  return board;
}

std::vector<Eigen::Vector3d> corners_mm(const Board& board) {
  std::vector<Eigen::Vector3d> corners;
  for (int r = 0; r < board.rows; ++r)
    for (int c = 0; c < board.columns; ++c)
      corners.emplace_back(c * board.square_mm, r * board.square_mm, 0);
  return corners;
}

std::optional<std::vector<Eigen::Vector2d>> find_board(const cv::Mat1b& grey, const Board& board) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(grey, {board.columns, board.rows}, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
    return std::nullopt;
  const int window =
      std::clamp(static_cast<int>(kWindowOfSpacing * smallest_spacing_px(corners, board)), 2,
                 kLargestWindowPx);
  cv::cornerSubPix(grey, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
  std::vector<Eigen::Vector2d> out;
  for (const cv::Point2f& p : corners) out.emplace_back(p.x, p.y);
  return out;
}

}  // namespace wheatstone
