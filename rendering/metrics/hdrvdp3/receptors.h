#pragma once
// Cones and rods: what light excites them how far, and how many thresholds that makes.
// Source: HDR-VDP-3 (reference metrics.md, section 4, steps 2 and 5).

#include <opencv2/core.hpp>

#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/hdrvdp3/log_table.h"

namespace wheatstone {

/// Columns L, M, S, rod; rows R, G, B: [L M S rod] = [R G B] M, light in cd/m^2. The lens of an
/// observer of age 24 is part of it. The columns L and M sum to 1 together.
const cv::Matx<double, 3, 4>& receptor_matrix(DisplaySpectra);

/// Response of one L or M cone, and of the rods, in just noticeable differences counted up from an
/// excitation of 10^-5.
const LogTable& cone_jnd();
const LogTable& rod_jnd();

}  // namespace wheatstone
