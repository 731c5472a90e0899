#pragma once
// ChArUco boards: chessboards with a marker in each white square, so that every corner is known
// also when a part of the board is hidden (S. Garrido-Jurado et al., Pattern Recognition 2014).

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/board.h"

namespace wheatstone {

/// The markers of a board; its squares are those of a Board. The layout is OpenCV 4.6's: the square
/// at the board's first corner is black, and markers count row by row.
struct CharucoMarkers {
  std::string dictionary;  // OpenCV's name, as in DICT_4X4_50
  double marker_mm = 0;
};

/// Throws ArgumentError for an unknown dictionary (lists those known), one with fewer markers than
/// the board has white squares, or markers that are not smaller than the squares.
void check_charuco(const Board&, const CharucoMarkers&);

struct CharucoSighting {
  std::vector<Eigen::Vector2d> corners_px;  // to a fraction of a pixel
  std::vector<int> corner_ids;              // into corners_mm() of the board
  std::size_t markers = 0;                  // found of this dictionary
};

/// What an 8-bit grey picture shows of the board: OpenCV's detectMarkers and
/// interpolateCornersCharuco, then cornerSubPix in a window that leaves out the markers.
/// Throws ArgumentError when the picture shows another board: markers that this one lacks, or most
/// of them elsewhere than they stand on it. Other arguments: as check_charuco().
CharucoSighting find_charuco(const cv::Mat1b& grey, const Board&, const CharucoMarkers&);

/// The smallest of OpenCV's dictionaries that finds most markers in the picture; "" if none does.
std::string dictionary_in(const cv::Mat1b& grey);

}  // namespace wheatstone
