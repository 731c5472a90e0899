#pragma once
// The check at the eye: what the driven displays send to an eye against what the box would send.

#include <array>
#include <optional>

#include "core/dataset.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {

struct EyeCheck {
  RgbImage displays, box;     // cd/m^2
  ScalarImage difference_pu;  // PU21 units
  double pu21_psnr_db = 0;
  double pu21_ssim = 0;    // of luminance
  double hdrvdp3_jod = 0;  // HDR-VDP-3 at the far display's pixels per degree; 10 = no difference
};

/// Presents the dataset's eight drive frames on the twin and photographs displays and real box
/// from both eyes; writes eye/<eye>_{displays,box}.exr. Order: left, right.
std::array<EyeCheck, 2> check_at_eye(const Dataset&, SimulatedRig&,
                                     std::optional<Luminance> limit = {});

}  // namespace wheatstone::apps
