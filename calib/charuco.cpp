#include "calib/charuco.h"

#include <algorithm>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

namespace aruco = cv::aruco;

struct Named {
  const char* name;
  int id;
};
#define WHEATSTONE_DICTIONARY(name) \
  Named {                           \
#name, aruco::name              \
  }
constexpr Named kDictionaries[] = {
    WHEATSTONE_DICTIONARY(DICT_4X4_50),         WHEATSTONE_DICTIONARY(DICT_4X4_100),
    WHEATSTONE_DICTIONARY(DICT_4X4_250),        WHEATSTONE_DICTIONARY(DICT_4X4_1000),
    WHEATSTONE_DICTIONARY(DICT_5X5_50),         WHEATSTONE_DICTIONARY(DICT_5X5_100),
    WHEATSTONE_DICTIONARY(DICT_5X5_250),        WHEATSTONE_DICTIONARY(DICT_5X5_1000),
    WHEATSTONE_DICTIONARY(DICT_6X6_50),         WHEATSTONE_DICTIONARY(DICT_6X6_100),
    WHEATSTONE_DICTIONARY(DICT_6X6_250),        WHEATSTONE_DICTIONARY(DICT_6X6_1000),
    WHEATSTONE_DICTIONARY(DICT_7X7_50),         WHEATSTONE_DICTIONARY(DICT_7X7_100),
    WHEATSTONE_DICTIONARY(DICT_7X7_250),        WHEATSTONE_DICTIONARY(DICT_7X7_1000),
    WHEATSTONE_DICTIONARY(DICT_ARUCO_ORIGINAL),
};
#undef WHEATSTONE_DICTIONARY

// Lens distortion moves a marker by less than this part of its side from where a plane puts it.
constexpr double kElsewhere = 0.5;

cv::Ptr<aruco::Dictionary> dictionary(const std::string& name) {
  std::string known;
  for (const Named& d : kDictionaries) {
    if (name == d.name) return aruco::getPredefinedDictionary(d.id);
    known += (known.empty() ? "" : ", ") + std::string(d.name);
  }
  throw ArgumentError("'" + name + "' is no marker dictionary", "use one of " + known);
}

struct Markers {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
};

Markers find_markers(const cv::Mat1b& grey, const cv::Ptr<aruco::Dictionary>& dictionary) {
  Markers found;
  aruco::detectMarkers(grey, dictionary, found.corners, found.ids);
  return found;
}

/// From a square's corner to the nearest marker, per axis, where the board is seen smallest.
double gap_px(const Markers& found, const Board& board, const CharucoMarkers& markers) {
  double smallest_px = cv::norm(found.corners[0][0] - found.corners[0][1]);
  for (const auto& c : found.corners)
    for (std::size_t i = 0; i < 4; ++i)
      smallest_px = std::min(smallest_px, cv::norm(c[i] - c[(i + 1) % 4]));
  return smallest_px * 0.5 * (board.square_mm - markers.marker_mm) / markers.marker_mm;
}

/// Throws when the markers are not those of this board, or stand in other places.
void require_this_board(const Markers& found, const aruco::CharucoBoard& charuco,
                        const Board& board) {
  const std::string other = "shows another board than one of " + std::to_string(board.columns) +
                            "x" + std::to_string(board.rows) + " inner corners";
  const std::string remedy = "count the inner corners, not the squares, for --board";
  std::vector<cv::Point2f> on_board, seen;
  double side_px = 0;
  for (std::size_t m = 0; m < found.ids.size(); ++m) {
    const auto at = std::find(charuco.ids.begin(), charuco.ids.end(), found.ids[m]);
    if (at == charuco.ids.end())
      throw ArgumentError(other + ": marker " + std::to_string(found.ids[m]) + " is not on it",
                          remedy);
    const auto& places = charuco.objPoints[static_cast<std::size_t>(at - charuco.ids.begin())];
    const cv::Point3f place = 0.25F * (places[0] + places[1] + places[2] + places[3]);
    const auto& c = found.corners[m];
    on_board.emplace_back(place.x, place.y);
    seen.push_back(0.25F * (c[0] + c[1] + c[2] + c[3]));
    side_px += cv::norm(c[0] - c[1]) / static_cast<double>(found.ids.size());
  }
  if (seen.size() < 5) return;  // four always lie on some plane
  std::vector<unsigned char> fits;
  cv::findHomography(on_board, seen, cv::RANSAC, kElsewhere * side_px, fits);
  if (2 * std::count(fits.begin(), fits.end(), 1) < static_cast<std::ptrdiff_t>(seen.size()))
    throw ArgumentError(other + ": its markers stand elsewhere", remedy);
}

}  // namespace

void check_charuco(const Board& board, const CharucoMarkers& markers) {
  const int available = dictionary(markers.dictionary)->bytesList.rows;
  const int needed = (board.columns + 1) * (board.rows + 1) / 2;
  if (needed > available)
    throw ArgumentError(markers.dictionary + " has " + std::to_string(available) +
                            " markers, and the board " + std::to_string(needed),
                        "give the dictionary the board was printed with");
  if (!(markers.marker_mm > 0) || !(markers.marker_mm < board.square_mm))
    throw ArgumentError("a board's markers must be smaller than its squares and above 0 mm",
                        "measure both, for example --square-mm 25 --marker-mm 18");
}

CharucoSighting find_charuco(const cv::Mat1b& grey, const Board& board,
                             const CharucoMarkers& markers) {
  check_charuco(board, markers);
  const auto charuco = aruco::CharucoBoard::create(
      board.columns + 1, board.rows + 1, static_cast<float>(board.square_mm),
      static_cast<float>(markers.marker_mm), dictionary(markers.dictionary));
  const Markers found = find_markers(grey, charuco->dictionary);
  CharucoSighting out;
  out.markers = found.ids.size();
  if (found.ids.empty()) return out;
  require_this_board(found, *charuco, board);
  std::vector<cv::Point2f> corners;
  aruco::interpolateCornersCharuco(found.corners, found.ids, grey, charuco, corners,
                                   out.corner_ids);
  if (corners.empty()) return out;
  // OpenCV counts these from the pixel's edge, not its centre, and stops refining at 0.1 px.
  for (cv::Point2f& p : corners) p -= cv::Point2f(0.5F, 0.5F);
  const int window = std::clamp(static_cast<int>(gap_px(found, board, markers)), 2, 11);
  cv::cornerSubPix(grey, corners, {window, window}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
  for (const cv::Point2f& p : corners) out.corners_px.emplace_back(p.x, p.y);
  return out;
}

std::string dictionary_in(const cv::Mat1b& grey) {
  std::string best;
  std::size_t most = 0;
  for (const Named& d : kDictionaries) {
    const std::size_t count = find_markers(grey, aruco::getPredefinedDictionary(d.id)).ids.size();
    if (count > most) {
      most = count;
      best = d.name;
    }
  }
  return best;
}

}  // namespace wheatstone
