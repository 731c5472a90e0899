#include "rendering/motion_quality/preset.h"

#include "core/error.h"

namespace wheatstone {

std::string to_string(MotionQualityPreset preset) {
  return preset == MotionQualityPreset::kReleased ? "released" : "published";
}

MotionQualityPreset motion_quality_preset_from_string(const std::string& name) {
  for (const auto preset : {MotionQualityPreset::kReleased, MotionQualityPreset::kPublished})
    if (name == to_string(preset)) return preset;
  throw ArgumentError("'" + name + "' is no preset of the motion-quality models",
                      "use released or published");
}

}  // namespace wheatstone
