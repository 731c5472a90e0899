#pragma once

#include <optional>
#include <string_view>

namespace wheatstone {

/// Seconds of an exposure time as cameras write it: "1/250", "0.5", "30", "13/10", also with s or
/// " behind. None for anything else ("Bulb", "Auto"), and for what is not above 0 and below 1e5.
/// Never throws.
std::optional<double> exposure_seconds(std::string_view);

}  // namespace wheatstone
