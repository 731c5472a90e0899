#pragma once
// The bytes that a Fadecandy takes (its firmware's README, "USB protocol").

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace wheatstone {

inline constexpr int kFadecandyPixels = 512, kFadecandyStrand = 64;
inline constexpr int kFadecandyLutEntries =
    257;  // per channel; entry i is for input 256 i of 65536

using FadecandyPixels = std::array<std::array<std::uint8_t, 3>, kFadecandyPixels>;
using FadecandyLut = std::array<std::array<std::uint16_t, kFadecandyLutEntries>, 3>;

/// Each is a whole number of 64-byte packets, for one bulk transfer.
std::vector<std::uint8_t> fadecandy_frame(const FadecandyPixels&);
std::vector<std::uint8_t> fadecandy_lut(const FadecandyLut&);
std::vector<std::uint8_t> fadecandy_config(bool dither, bool interpolate);

/// Code c shows the light (c / 255)^code_gamma when a LED's light is drive^response_gamma.
FadecandyLut fadecandy_response(double code_gamma, const std::array<double, 3>& response_gamma);

}  // namespace wheatstone
