#include "capture/import/imported_view.h"

#include <opencv2/imgproc.hpp>

#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/png.h"

namespace wheatstone {
namespace {

RgbImage read_picture(const std::filesystem::path& path, double white_cd_m2) {
  if (path.extension() != ".exr") return read_srgb_picture(path, white_cd_m2);
  ExrMetadata metadata;
  RgbImage light = read_exr(path, &metadata);
  if (!metadata.has_bt709_chromaticities)
    throw FileError(path, "has primaries other than BT.709", "convert it to BT.709");
  light.pixels *= metadata.white_luminance_cd_m2 > 0 ? metadata.white_luminance_cd_m2 : white_cd_m2;
  return light;
}

}  // namespace

LightFieldView load_view(const ImportedView& view, double white_cd_m2) {
  if (view.path.empty())
    throw FileError(view.name, "the picture of this view is not there",
                    "put it beside the others or leave the view out");
  LightFieldView out{view.name, read_picture(view.path, white_cd_m2), view.intrinsics,
                     view.T_camera_world};
  const Intrinsics& k = view.intrinsics;
  const cv::Size size(k.width_px, k.height_px);
  if (out.light_cd_m2.pixels.size() != size)
    throw FileError(view.path,
                    "the picture is " + std::to_string(out.light_cd_m2.width()) + " x " +
                        std::to_string(out.light_cd_m2.height()) + ", its camera " +
                        std::to_string(k.width_px) + " x " + std::to_string(k.height_px),
                    "use the unscaled, unrotated picture the poses were computed from");
  if (view.distortion.is_zero()) return out;

  cv::Mat2f source(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double yn = (y - k.cy_px) / k.fy_px;
      const Eigen::Vector2d d =
          distort(view.distortion, {(x - k.cx_px - k.skew_px * yn) / k.fx_px, yn});
      source(y, x) = {static_cast<float>(k.fx_px * d.x() + k.skew_px * d.y() + k.cx_px),
                      static_cast<float>(k.fy_px * d.y() + k.cy_px)};
    }
  }
  cv::Mat3f straight;
  cv::remap(out.light_cd_m2.pixels, straight, source, cv::noArray(), cv::INTER_LINEAR,
            cv::BORDER_CONSTANT);
  out.light_cd_m2.pixels = straight;
  return out;
}

cv::Size picture_size(const std::filesystem::path& path) {
  const auto bytes = read_bytes(path);
  const auto u8 = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  const auto u16 = [&](std::size_t i) { return static_cast<int>(u8(i) << 8 | u8(i + 1)); };
  if (bytes.size() >= 24 && u8(0) == 0x89 && u8(1) == 'P' && u8(2) == 'N' && u8(3) == 'G' &&
      u16(16) == 0 && u16(20) == 0)
    return {u16(18), u16(22)};
  if (bytes.size() >= 4 && u8(0) == 0xff && u8(1) == 0xd8) {
    // Segments are FF, marker, length; frame headers are C0..CF without C4, C8 and CC.
    for (std::size_t i = 2; i + 9 <= bytes.size() && u8(i) == 0xff;) {
      const unsigned marker = u8(i + 1);
      if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc)
        return {u16(i + 7), u16(i + 5)};
      i += marker == 0xff ? 1 : 2 + static_cast<std::size_t>(u16(i + 2));
    }
  }
  throw FileError(path, "neither a JPEG nor a PNG with a readable header",
                  "export the picture again as JPEG or PNG");
}

}  // namespace wheatstone
