#include "rendering/metrics/pu21.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "rendering/metrics/pu21_glsl.h"
#include "rendering/metrics/pu21_table.h"

namespace wheatstone {
namespace {

struct Parameters {
  double p1, p2, p3, p4, p5, p6, p7;
};

const Parameters& parameters(Pu21Variant variant) {
  static constexpr std::array<Parameters, 4> kParameters = {{
      {1.070275272, 0.4088273932, 0.153224308, 0.2520326168, 1.063512885, 1.14115047, 521.4527484},
      {0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166, 0.9099517204,
       596.3148142},
      {1.043882782, 0.6459495343, 0.3194584211, 0.374025247, 1.114783422, 1.095360363, 384.9217577},
      {816.885024, 1479.463946, 0.001253215609, 0.9329636822, 0.06746643971, 1.573435413,
       419.6006374},
  }};
  return kParameters[static_cast<std::size_t>(variant)];
}

constexpr std::array<const char*, 4> kNames = {"banding", "banding_glare", "peaks", "peaks_glare"};

}  // namespace

std::string to_string(Pu21Variant variant) {
  return kNames[static_cast<std::size_t>(variant)];
}

Pu21Variant pu21_variant_from_string(const std::string& text) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (text == kNames[i]) return static_cast<Pu21Variant>(i);
  throw ArgumentError("'" + text + "' is no PU21 variant",
                      "use banding, banding_glare, peaks or peaks_glare");
}

double detail::pu21_curve(double luminance_cd_m2, Pu21Variant variant) {
  const Parameters& p = parameters(variant);
  const double y = std::pow(luminance_cd_m2, p.p4);
  return p.p7 * (std::pow((p.p1 + p.p2 * y) / (1 + p.p3 * y), p.p5) - p.p6);
}

double pu21_encode(double luminance_cd_m2, Pu21Variant variant) {
  return std::max(
      detail::pu21_curve(std::clamp(luminance_cd_m2, kPu21MinCdM2, kPu21MaxCdM2), variant), 0.0);
}

double pu21_decode(double pu21, Pu21Variant variant) {
  const Parameters& p = parameters(variant);
  const double v = std::pow(std::max(pu21 / p.p7 + p.p6, 0.0), 1 / p.p5);
  return std::pow(std::max(v - p.p1, 0.0) / (p.p2 - p.p3 * v), 1 / p.p4);
}

const char* pu21_glsl() {
  return kPu21Glsl;
}

void pu21_encode(std::span<const float> luminance_cd_m2, std::span<float> pu21,
                 Pu21Variant variant) {
  const std::size_t count = luminance_cd_m2.size();
  if (count != pu21.size())
    throw ArgumentError(fmt::format("{} luminances for {} PU21 values", count, pu21.size()),
                        "give as many of both");
  if (detail::pu21_encode_span(detail::pu21_table(variant), luminance_cd_m2.data(), count,
                               pu21.data(), best_simd()))
    return;
  const auto impossible = [](float v) { return !(std::isfinite(v) && v >= 0); };
  const auto first = std::find_if(luminance_cd_m2.begin(), luminance_cd_m2.end(), impossible);
  throw ArgumentError(
      fmt::format("{} of {} luminances are NaN, infinite or negative, the first at index {}",
                  std::count_if(first, luminance_cd_m2.end(), impossible), count,
                  first - luminance_cd_m2.begin()),
      "repair or leave out this image");
}

}  // namespace wheatstone
