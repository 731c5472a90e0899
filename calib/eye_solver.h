#pragma once
// One eye in front of one display: which LCD pixel it sees on which point of the box.

#include <span>

#include "core/rig_types.h"

namespace wheatstone {

/// P_lcd_rsb = K [R | t] from aligned marks: normalised DLT, then least squares on the pixel
/// distances (Hartley and Zisserman 2004, ch. 7). K has a positive diagonal and K(2,2) = 1,
/// det R = +1; rms_px is the root mean square length of the residuals. LCD rows go down (rsb -y).
///
/// Throws ArgumentError for fewer than 6 marks, for marks on one plane or otherwise degenerate,
/// for marks of which some lie behind the eye, and for a mirrored LCD image.
EyeDisplayCalibration solve_eye_display(DisplayId, std::span<const Alignment>, int lcd_width_px,
                                        int lcd_height_px);

}  // namespace wheatstone
