#pragma once
// Thesis: G. Denes / A. Jindal's models of motion quality as printed in UCAM-CL-TR-977. Its
// equations and the programs that its authors released differ in places; both are kept.

#include <string>

namespace wheatstone {

/// kReleased: the released programs, which reproduce the thesis's tables of results.
/// kPublished: the equations and constants as the thesis prints them (each model's header says
/// which differ).
enum class MotionQualityPreset { kReleased, kPublished };

std::string to_string(MotionQualityPreset);
/// "released" or "published"; ArgumentError otherwise.
MotionQualityPreset motion_quality_preset_from_string(const std::string&);

}  // namespace wheatstone
