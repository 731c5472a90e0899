#pragma once
// Contrast sensitivity that is left when the eye's optics are taken out of it.
// Source: HDR-VDP-3 (reference metrics.md, section 4, step 7).

#include "rendering/metrics/hdrvdp3/log_table.h"

namespace wheatstone {

/// Sensitivity (1 / threshold contrast) to a grating of rho_cpd >= 0 at an adaptation luminance,
/// which counts as 0.0002..150 cd/m^2 outside that range. 0 at 0 cpd.
double neural_csf(double rho_cpd, double luminance_cd_m2);

/// The same for one frequency over luminance, 256 samples.
LogTable neural_csf_table(double rho_cpd);

}  // namespace wheatstone
