#include "capture/import/colmap_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone::colmap_detail {

Lens lens_of(const Camera& c) {
  const auto& p = c.parameters;
  if (c.width < 1 || c.height < 1 || c.width > 65536 || c.height > 65536)
    c.place.fail("a picture size outside 1..65536 px");
  if (!std::all_of(p.begin(), p.end(), [](double v) { return std::isfinite(v); }))
    c.place.fail("a camera parameter that is not a number");
  const bool two_focal_lengths = c.model == "PINHOLE" || c.model.find("OPENCV") != c.model.npos;
  const std::size_t centre = two_focal_lengths ? 2 : 1;
  Lens lens;
  lens.intrinsics = {p[0],
                     p[centre - 1],
                     0,
                     p[centre] - kPixelCentre,
                     p[centre + 1] - kPixelCentre,
                     static_cast<int>(c.width),
                     static_cast<int>(c.height)};
  if (!(p[0] > 0) || !(p[centre - 1] > 0)) c.place.fail("a focal length that is not above 0");
  Distortion& d = lens.distortion;
  const auto at = [&](std::size_t i) { return centre + 2 + i < p.size() ? p[centre + 2 + i] : 0; };
  d.k1 = at(0), d.k2 = at(1);
  if (c.model == "OPENCV_FISHEYE") {
    d.k3 = at(2), d.k4 = at(3), d.fisheye = true;
  } else {
    d.p1 = at(2), d.p2 = at(3), d.k3 = at(4), d.k4 = at(5), d.k5 = at(6), d.k6 = at(7);
  }
  return lens;
}

Camera camera_of(std::uint64_t id, const Intrinsics& k, const Distortion& d) {
  if (k.skew_px != 0)
    throw ArgumentError("COLMAP has no camera model with skew", "export in another format");
  Camera c;
  c.id = id;
  c.width = static_cast<std::uint64_t>(k.width_px);
  c.height = static_cast<std::uint64_t>(k.height_px);
  c.parameters = {k.fx_px, k.fy_px, k.cx_px + kPixelCentre, k.cy_px + kPixelCentre};
  const auto add = [&](std::initializer_list<double> v) {
    c.parameters.insert(c.parameters.end(), v);
  };
  if (d.fisheye) {
    c.model = "OPENCV_FISHEYE";
    add({d.k1, d.k2, d.k3, d.k4});
  } else if (d.is_zero()) {
    c.model = "PINHOLE";
  } else if (d.has_five_coefficients() && d.k3 == 0) {
    c.model = "OPENCV";
    add({d.k1, d.k2, d.p1, d.p2});
  } else {
    c.model = "FULL_OPENCV";
    add({d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6});
  }
  return c;
}

std::string camera_line(const Camera& c) {
  return fmt::format("{} {} {} {} {}", c.id, c.model, c.width, c.height,
                     fmt::join(c.parameters, " "));
}

}  // namespace wheatstone::colmap_detail
