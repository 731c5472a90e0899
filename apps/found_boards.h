#pragma once
// Chessboards and ChArUco boards in the pictures of a folder.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/stations.h"
#include "calib/camera_solver.h"
#include "calib/charuco.h"

namespace wheatstone::apps {

/// The boards found in the pictures of a folder.
struct FoundBoards {
  int width_px = 0, height_px = 0;
  std::vector<BoardView> views;            // named by their path below the folder
  std::vector<std::string> without_board;  // pictures that do not show (enough of) the board
  std::vector<std::string> larger_board;   // pictures whose chessboard goes on beyond the corners
};

/// Finds the board in every JPEG, PNG, TIFF and BMP below `folder` whose relative path matches the
/// shell pattern `match` (* does not match /), in the order of names.
/// With `markers` it is a ChArUco board, of which kMinCorners corners are enough, not all on one
/// line.
/// Errors: FileError: no such folder, no picture, a damaged one, two sizes (names both), no board
/// in any picture, another ChArUco board; ArgumentError as check_charuco().
FoundBoards find_boards(const std::filesystem::path& folder, const std::string& match, const Board&,
                        const std::optional<CharucoMarkers>& markers, const Progress&);

/// The pictures below the folder that match, relative to it, in the order of names. Errors: as
/// find_boards().
std::vector<std::filesystem::path> pictures_below(const std::filesystem::path& folder,
                                                  const std::string& match);

}  // namespace wheatstone::apps
