#include "apps/light_input.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "core/error.h"
#include "core/exr.h"
#include "core/hdr_files.h"
#include "core/png.h"

namespace wheatstone::apps {
namespace {

enum class Format { kExr, kPfm, kRadiance, kEncoded };

std::optional<Format> format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  static constexpr std::pair<const char*, Format> kFormats[] = {
      {".exr", Format::kExr},      {".pfm", Format::kPfm},     {".hdr", Format::kRadiance},
      {".pic", Format::kRadiance}, {".png", Format::kEncoded}, {".tif", Format::kEncoded},
      {".tiff", Format::kEncoded}, {".jpg", Format::kEncoded}, {".jpeg", Format::kEncoded}};
  for (const auto& [name, format] : kFormats)
    if (extension == name) return format;
  return std::nullopt;
}

RgbImage read_exr_light(const std::filesystem::path& path, std::optional<LightScale>& scale) {
  ExrMetadata metadata;
  RgbImage image = read_exr(path, &metadata);
  if (!metadata.has_bt709_chromaticities)
    throw FileError(path, "has primaries other than BT.709", "convert it to BT.709");
  if (metadata.white_luminance_cd_m2 > 0)
    scale = LightScale::of_one(Luminance::of(metadata.white_luminance_cd_m2));
  return image;
}

}  // namespace

bool is_picture(const std::filesystem::path& path) {
  return format_of(path).has_value();
}

RgbImage read_light(const std::filesystem::path& path, const LightOptions& options) {
  const std::optional<Format> format = format_of(path);
  if (!format)
    throw FileError(path, "is of no format that this program reads",
                    "give EXR, PFM, Radiance HDR, PNG, TIFF or JPEG");
  if (*format == Format::kEncoded) {
    if (!options.peak_cd_m2)
      throw FileError(path, "does not say how bright its full code is", "give --peak-cd-m2");
    GogDisplay display = options.display;
    display.peak_cd_m2 = *options.peak_cd_m2;
    return read_encoded_picture(path, [&](double v) { return display.light_cd_m2(v); });
  }
  std::optional<LightScale> scale;
  if (options.absolute)
    scale = LightScale::absolute();
  else if (options.peak_cd_m2)
    scale = LightScale::of_one(Luminance::of(*options.peak_cd_m2));
  RgbImage image = *format == Format::kExr   ? read_exr_light(path, scale)
                   : *format == Format::kPfm ? read_pfm(path)
                                             : read_radiance_hdr(path);
  if (!scale)
    throw FileError(path, "does not say what its values are in cd/m²",
                    "give --absolute if they are cd/m², or --peak-cd-m2, the light of value 1");
  return scale->light(std::move(image));
}

cv::Mat1b read_mask(const std::filesystem::path& path) {
  const RgbImage picture = read_encoded_picture(path, [](double v) { return v; });
  cv::Mat1b mask(picture.pixels.size(), static_cast<unsigned char>(0));
  for (int r = 0; r < mask.rows; ++r)
    for (int c = 0; c < mask.cols; ++c)
      if (picture.pixels(r, c) != cv::Vec3f(0, 0, 0)) mask(r, c) = 255;
  return mask;
}

}  // namespace wheatstone::apps
