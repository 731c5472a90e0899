#pragma once
// The fewest exposures with which a whole scene reaches a stated signal-to-noise ratio.
// Noise model and merge: reference hdr_merge.md, sec. 1 and 2.

#include <stop_token>
#include <vector>

#include "capture/plan.h"
#include "core/rig_types.h"
#include "hardware/rig.h"

namespace wheatstone {

/// How bright the scene is, over all photosites of the probed views.
struct LightRange {
  double brightest_dn_s = 0;  // DN/s at ISO 100, black subtracted
  double darkest_e_s = 0;     // electrons/s, a tenth below what all but 1 - coverage of them exceed
};

/// Signal-to-noise ratio that a merge of `frames` exposures with `electrons` in all of them has.
double signal_to_noise(double electrons, int frames, const CameraProfile&);

struct ExposureLimits {
  double shortest_s = 1.0 / 8000, longest_s = 30;
};

/// Times in ascending order, so that every light in the range reaches `wanted` after the merge: the
/// shortest keeps the brightest light a fifth below saturation, every further one is as long as the
/// light that saturates in it allows, given what the shorter ones have gathered of that. No set
/// with fewer times does it. Errors: ArgumentError: wanted <= 0; a range without light; a ratio
/// that the camera cannot reach even just below saturation, or not within its longest exposure (the
/// message says how far it gets).
std::vector<double> plan_exposures(const LightRange&, const CameraProfile&, double wanted,
                                   const ExposureLimits& = {});

/// Homes the stage, lights the ceiling and takes frames at the first, middle and last position of
/// the plan, shorter and longer ones until nothing saturates and the darkest is well seen. Lights
/// are off when it returns or throws. coverage: in (0, 1). Errors: ArgumentError (coverage),
/// DeviceError, Cancelled.
LightRange probe_light(const Rig&, const CapturePlan&, double coverage,
                       const std::stop_token& stop);

}  // namespace wheatstone
