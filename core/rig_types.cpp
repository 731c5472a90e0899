#include "core/rig_types.h"

#include "core/error.h"

namespace wheatstone {

std::string to_string(Eye eye) {
  return eye == Eye::kLeft ? "left" : "right";
}
std::string to_string(Plane plane) {
  return plane == Plane::kNear ? "near" : "far";
}
std::string to_string(DisplayId id) {
  return to_string(id.eye) + "_" + to_string(id.plane);
}

DisplayId display_from_string(const std::string& text) {
  for (DisplayId id : kDisplays)
    if (to_string(id) == text) return id;
  throw ArgumentError("'" + text + "' is no display",
                      "use left_near, left_far, right_near or right_far");
}

}  // namespace wheatstone
