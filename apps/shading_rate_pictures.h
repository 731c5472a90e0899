#pragma once
// Pictures of shading-rate allocations, for people.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/image.h"
#include "rendering/motion_quality/alsarr/rate_allocation.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone::apps {

/// One colour per rate, dark for coarse, with a legend that says how many tiles have it.
cv::Mat3b rate_map_picture(const ShadingRateMap&, const std::string& title);

/// What each tile gains over 4x4, in model units; 99 % of the tiles lie within the scale.
/// quality: [tile][rate], tiles column by column, as in AllocationProblem.
cv::Mat3b quality_map_picture(const std::vector<double>& quality, const ShadingRateMap&,
                              const std::string& title);

/// A picture shaded at different rates, each time below its caption, and the last map beside them:
/// sRGB, R, G, B, all of one size; small ones are enlarged so that single pixels can be seen.
struct ShadedPicture {
  cv::Mat3b rgb;
  ShadingRateMap map;
  std::string caption;
};
cv::Mat3b side_by_side(const std::vector<ShadedPicture>&, const std::string& title);

}  // namespace wheatstone::apps
