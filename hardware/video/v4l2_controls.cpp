#include "hardware/video/v4l2_controls.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cmath>
#include <optional>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr double kExposureUnitS = 100e-6;

struct Automatic {
  std::uint32_t id;
  std::int32_t off;
  const char* name;
};
// Their "off" comes before the value that they govern, which the camera refuses otherwise.
constexpr Automatic kAutomatics[] = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "exposure"},
                                     {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0, "frame rate"},
                                     {V4L2_CID_AUTOGAIN, 0, "gain"},
                                     {V4L2_CID_AUTO_WHITE_BALANCE, 0, "white balance"},
                                     {V4L2_CID_FOCUS_AUTO, 0, "focus"}};
constexpr std::uint32_t kProcessing[] = {V4L2_CID_SHARPNESS, V4L2_CID_BACKLIGHT_COMPENSATION,
                                         V4L2_CID_POWER_LINE_FREQUENCY};

// None: the camera lacks it, or does not let it be set.
std::optional<v4l2_queryctrl> query(V4l2Node& node, std::uint32_t id) {
  v4l2_queryctrl about{};
  about.id = id;
  if (node.ask(VIDIOC_QUERYCTRL, &about, "tell its controls") != 0) return {};
  if (about.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) return {};
  return about;
}

std::int32_t set(V4l2Node& node, std::uint32_t id, std::int32_t value, const Deadline& deadline) {
  v4l2_control control{id, value};
  node.call(VIDIOC_S_CTRL, &control, "be set up", deadline);
  node.call(VIDIOC_G_CTRL, &control, "tell how it is set up", deadline);
  return control.value;
}

void require_within(const V4l2Node& node, const v4l2_queryctrl& limits, double value, double unit,
                    const char* name) {
  if (value >= limits.minimum - 0.5 && value <= limits.maximum + 0.5) return;
  throw DeviceError(Kind::kOutOfRange,
                    fmt::format("{} has no {} {:g}", node.what(), name, value * unit),
                    fmt::format("use {:g} to {:g}", limits.minimum * unit, limits.maximum * unit));
}

}  // namespace

void switch_automatics_off(V4l2Node& node, const Deadline& deadline) {
  for (const Automatic& a : kAutomatics) {
    if (!query(node, a.id)) continue;
    if (set(node, a.id, a.off, deadline) != a.off)
      throw DeviceError(Kind::kFault, fmt::format("{} keeps its automatic {}", node.what(), a.name),
                        "use a camera with manual control");
  }
  for (const std::uint32_t id : kProcessing)
    if (const auto about = query(node, id)) set(node, id, about->minimum, deadline);
}

void require_within_limits(V4l2Node& node, Duration exposure, double gain,
                           const Deadline& deadline) {
  node.check(deadline);
  if (!(exposure.value() > 0) || !std::isfinite(gain))
    throw DeviceError(
        Kind::kOutOfRange,
        fmt::format("{} has no exposure of {} s at gain {}", node.what(), exposure.value(), gain),
        "use a positive time and the camera's own units of gain");
  if (const auto limits = query(node, V4L2_CID_EXPOSURE_ABSOLUTE))
    require_within(node, *limits, exposure.value() / kExposureUnitS, kExposureUnitS,
                   "exposure [s] of");
  if (const auto limits = query(node, V4L2_CID_GAIN))
    require_within(node, *limits, gain, 1, "gain of");
}

Duration set_exposure(V4l2Node& node, Duration exposure, const Deadline& deadline) {
  if (!query(node, V4L2_CID_EXPOSURE_ABSOLUTE)) return {};
  const auto units = static_cast<std::int32_t>(std::lround(exposure.value() / kExposureUnitS));
  return Duration::of(kExposureUnitS * set(node, V4L2_CID_EXPOSURE_ABSOLUTE, units, deadline));
}

double set_gain(V4l2Node& node, double gain, const Deadline& deadline) {
  if (!query(node, V4L2_CID_GAIN)) return 0;
  return set(node, V4L2_CID_GAIN, static_cast<std::int32_t>(std::lround(gain)), deadline);
}

}  // namespace wheatstone
