#pragma once
// Who a display says it is (VESA E-EDID 1.4, section 3).

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "hardware/display_outputs.h"

namespace wheatstone {

inline constexpr std::size_t kEdidBlock = 128;

/// Of the base block, the first 128 bytes; what follows is not looked at. Nothing if it is shorter,
/// does not begin as an EDID does, or its sum is wrong. Texts hold printable ASCII only.
std::optional<EdidIdentity> parse_edid(std::span<const std::byte>);

/// A base block with this identity and nothing else that would matter, for emulated displays.
/// Throws ArgumentError unless the manufacturer is three capital letters and the texts have at most
/// 13 characters.
std::vector<std::byte> compose_edid(const EdidIdentity&);

}  // namespace wheatstone
