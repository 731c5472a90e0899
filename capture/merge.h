#pragma once
// One linear mosaic from an exposure stack (reference hdr_merge.md, sec. 1 and 2).

#include <opencv2/core.hpp>
#include <span>

#include "core/image.h"
#include "core/rig_types.h"
#include "core/units.h"

namespace wheatstone {

/// One raw frame of a stack.
struct RawExposure {
  MosaicImage frame;
  Duration exposure;
  double gain = 1;  // ISO / 100
};

struct MergedMosaic {
  LinearMosaic mosaic;   // DN/s at ISO 100, black level subtracted; may be negative
  cv::Mat1f sigma_dn_s;  // standard deviation by the camera's noise model, same size
  cv::Mat1b saturated;   // 255 where the cell is saturated even in the shortest exposure
};

/// Poisson-optimal merge: sum of (DN - black)/gain over sum of times, over the frames whose whole
/// 2x2 cell is strictly below white_dn. The shortest exposure (least time x gain) is always used.
/// The order of the frames does not matter. Throws ArgumentError, naming the frame's index, for
/// sizes or patterns that disagree, for times or gains that are not positive, and for two frames
/// of the same exposure; also for an empty stack and a profile without white_dn > black_dn.
MergedMosaic merge_exposures(std::span<const RawExposure>, const CameraProfile&);

}  // namespace wheatstone
