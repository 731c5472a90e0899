#include "capture/merged_exr.h"

#include "capture/demosaic.h"
#include "capture/radiance.h"
#include "core/exr.h"

namespace wheatstone {
namespace {

using FillPicture = std::function<void(cv::Range rows, std::span<cv::Mat1f> bands)>;

/// Adds the layers to a picture whose channels come first and are filled by `fill_picture`; `sigma`
/// in the picture's unit, empty without noise parameters.
void write(const std::filesystem::path& path, ExrPicture picture, const MergedMosaic& merged,
           const cv::Mat1f& sigma, const FillPicture& fill_picture) {
  const std::size_t own = picture.channels.size();
  picture.size = merged.flags.size();
  picture.compression = ExrCompression::kPiz;
  std::vector<std::uint8_t> bits;
  const auto add = [&](const std::string& name, std::uint8_t bit) {
    picture.channels.push_back({name, ExrPrecision::kHalf});
    bits.push_back(bit);
  };
  add("mask.saturated", kSaturated);
  add("mask.single_source", kSingleSource);
  const bool has_sigma = !sigma.empty();
  if (has_sigma) {
    add("mask.underexposed", kUnderexposed);
    picture.channels.push_back({"sigma.Y", ExrPrecision::kFloat});
  }
  write_exr_rows(path, picture, [&](cv::Range rows, std::span<cv::Mat1f> bands) {
    fill_picture(rows, bands.first(own));
    const cv::Mat1b flags = merged.flags.rowRange(rows);
    for (std::size_t i = 0; i < bits.size(); ++i) {
      const cv::Mat1b set = (flags & bits[i]) != 0;
      set.convertTo(bands[own + i], CV_32F, 1.0 / 255);
    }
    if (has_sigma) sigma.rowRange(rows).copyTo(bands.back());
  });
}

ExrPicture rgb(ExrPrecision precision, bool is_light) {
  return {{}, {{"R", precision}, {"G", precision}, {"B", precision}}, is_light};
}

}  // namespace

void write_merged_mosaic_exr(const std::filesystem::path& path, const MergedMosaic& merged) {
  write(path, {{}, {{"Y"}}}, merged, merged.sigma_dn_s,
        [&](cv::Range rows, std::span<cv::Mat1f> bands) {
          merged.mosaic.values.rowRange(rows).copyTo(bands[0]);
        });
}

void write_merged_camera_exr(const std::filesystem::path& path, const MergedMosaic& merged) {
  cv::Mat3f band;
  write(path, rgb(ExrPrecision::kFloat, false), merged, merged.sigma_dn_s,
        [&](cv::Range rows, std::span<cv::Mat1f> bands) {
          demosaic_rows(merged.mosaic, rows, band);
          cv::split(band, bands.data());
        });
}

void write_merged_light_exr(const std::filesystem::path& path, const MergedMosaic& merged,
                            const CameraProfile& camera) {
  cv::Mat3f band;
  write(path, rgb(ExrPrecision::kHalf, true), merged, luminance_deviation(merged, camera),
        [&](cv::Range rows, std::span<cv::Mat1f> bands) {
          demosaic_rows(merged.mosaic, rows, band);
          cv::split(to_radiance(band, camera).pixels, bands.data());
        });
}

}  // namespace wheatstone
