#pragma once
// Chessboards: where their inner corners are on the board, and where in a picture.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace wheatstone {

/// A flat chessboard by its inner corners. Frame `board`: origin at the first corner, x along a
/// row, y along a column, z into the board; mm.
struct Board {
  int columns = 0, rows = 0;
  double square_mm = 0;

  std::size_t corners() const { return static_cast<std::size_t>(columns) * rows; }
  /// Turned by half a turn it looks the same, so the first corner may be either of two.
  bool is_symmetric() const { return (columns + rows) % 2 == 0; }
};

/// "9x6", inner corners per row and column. Throws ArgumentError unless both are 3 to 100 and
/// square_mm is above 0.
Board board_from_string(const std::string& columns_x_rows, double square_mm);

/// The corners in `board`, row by row, mm.
std::vector<Eigen::Vector3d> corners_mm(const Board&);

/// The corners in an 8-bit grey picture to a fraction of a pixel, in the order of corners_mm();
/// nothing when the whole board is not seen. OpenCV's findChessboardCorners, then cornerSubPix in
/// a window that stays within the squares around the corner.
std::optional<std::vector<Eigen::Vector2d>> find_board(const cv::Mat1b& grey, const Board&);

/// Whether the pattern goes on beyond one of the four sides of a board that find_board() found: the
/// squares alternate around most of the places where the next row or column of inner corners would
/// be, so that the real board is larger. Places outside the picture do not count; with fewer than 3
/// left on a side, nothing is said about it.
bool goes_on_beyond(const cv::Mat1b& grey, const Board&,
                    const std::vector<Eigen::Vector2d>& corners_px);

}  // namespace wheatstone
