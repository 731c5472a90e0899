#pragma once
// What a V4L2 camera offers.

#include <vector>

#include "hardware/video/v4l2_node.h"
#include "hardware/video_camera.h"

namespace wheatstone {

/// As V4l2Camera::modes(). Throws kProtocol for lists without end.
std::vector<VideoMode> list_modes(V4l2Node&, const Deadline&);

}  // namespace wheatstone
