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

constexpr double kIntoSquare = 0.35;    // of a square's sides, from a corner
constexpr double kLeastContrast = 0.5;  // of the next corner's
constexpr double kMostOfSide = 0.8;
constexpr std::size_t kFewestPlaces = 3;

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

/// How much the four squares around `p` alternate: above 0 where those along along + across are
/// the brighter ones, below 0 where they are the darker ones, near 0 for anything but a corner.
/// Nothing where the picture ends. `along`, `across`: the sides of a square, px.
std::optional<double> alternation(const cv::Mat1b& grey, const Eigen::Vector2d& p,
                                  const Eigen::Vector2d& along, const Eigen::Vector2d& across) {
  const auto square = [&](double a, double b) -> std::optional<double> {
    const Eigen::Vector2d at = p + kIntoSquare * (a * along + b * across);
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    if (!(x >= 1 && y >= 1 && x < grey.cols - 1 && y < grey.rows - 1)) return std::nullopt;
    return cv::mean(grey(cv::Rect(x - 1, y - 1, 3, 3)))[0];
  };
  const auto a = square(1, 1), b = square(-1, -1), c = square(1, -1), d = square(-1, 1);
  if (!a || !b || !c || !d) return std::nullopt;
  const double brighter = std::min(*a, *b) - std::max(*c, *d);
  const double darker = std::min(*c, *d) - std::max(*a, *b);
  return brighter > 0 ? brighter : darker > 0 ? -darker : 0;
}

/// One side of the board: inwards(i, k) is the i-th corner along it, k rows into the board.
template <class Inwards>
bool goes_on_beyond_side(const cv::Mat1b& grey, int count, Inwards inwards) {
  std::vector<Eigen::Vector2d> next;  // by the last three, since perspective shortens squares
  for (int i = 0; i < count; ++i)
    next.push_back(3 * inwards(i, 0) - 3 * inwards(i, 1) + inwards(i, 2));
  std::size_t places = 0, corners = 0;
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int from = std::max(i - 1, 0), to = std::min(i + 1, count - 1);
    const Eigen::Vector2d along =
        (next[static_cast<std::size_t>(to)] - next[static_cast<std::size_t>(from)]) / (to - from);
    const Eigen::Vector2d across = next[at] - inwards(i, 0);
    const auto here = alternation(grey, next[at], along, across);
    const auto last = alternation(grey, inwards(i, 0), along, across);
    if (!here || !last) continue;
    ++places;
    // The colours of a chessboard change from each corner to the next.
    if (*here * *last < 0 && std::abs(*here) > kLeastContrast * std::abs(*last)) ++corners;
  }
  return places >= kFewestPlaces &&
         static_cast<double>(corners) >= kMostOfSide * static_cast<double>(places);
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

bool goes_on_beyond(const cv::Mat1b& grey, const Board& board,
                    const std::vector<Eigen::Vector2d>& corners_px) {
  if (corners_px.size() != board.corners())
    throw ArgumentError(std::to_string(corners_px.size()) + " corners are not those of the board",
                        "give all that find_board() found");
  const int columns = board.columns, rows = board.rows;
  const auto at = [&](int column, int row) {
    return corners_px[static_cast<std::size_t>(row * columns + column)];
  };
  return goes_on_beyond_side(grey, columns, [&](int i, int k) { return at(i, k); }) ||
         goes_on_beyond_side(grey, columns, [&](int i, int k) { return at(i, rows - 1 - k); }) ||
         goes_on_beyond_side(grey, rows, [&](int i, int k) { return at(k, i); }) ||
         goes_on_beyond_side(grey, rows, [&](int i, int k) { return at(columns - 1 - k, i); });
}

}  // namespace wheatstone
