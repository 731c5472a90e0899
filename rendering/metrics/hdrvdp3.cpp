#include "rendering/metrics/hdrvdp3.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "rendering/metrics/hdrvdp3/plane.h"
#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"
#include "rendering/metrics/hdrvdp3/visible_difference.h"
#include "rendering/metrics/hdrvdp3/visual_pathway.h"

namespace wheatstone {
namespace {

void require_comparable(const RgbImage& test, const RgbImage& reference,
                        const HdrVdp3Options& options) {
  const double ppd = options.pixels_per_degree;
  if (!(ppd >= kHdrVdp3MinPixelsPerDegree && ppd <= kHdrVdp3MaxPixelsPerDegree))
    throw ArgumentError(
        fmt::format("{} pixels per degree are outside {}..{}", ppd, kHdrVdp3MinPixelsPerDegree,
                    kHdrVdp3MaxPixelsPerDegree),
        "give the image's width in pixels divided by the visual angle it fills, in degrees");
  if (options.observer_age_years != kHdrVdp3ObserverAgeYears)
    throw ArgumentError(
        fmt::format("HDR-VDP-3 cannot judge for an observer of age {}: its receptor data are for "
                    "the lens of age {}",
                    options.observer_age_years, kHdrVdp3ObserverAgeYears),
        fmt::format("use age {}", kHdrVdp3ObserverAgeYears));
  if (test.pixels.size() != reference.pixels.size())
    throw ArgumentError(
        fmt::format("the test image has {}x{} pixels, the reference image {}x{}", test.width(),
                    test.height(), reference.width(), reference.height()),
        "compare images of one size");
  if (std::min(test.width(), test.height()) < kHdrVdp3MinSidePx)
    throw ArgumentError(
        fmt::format("images of {}x{} pixels are too small for HDR-VDP-3", test.width(),
                    test.height()),
        fmt::format("compare images of at least {0}x{0} pixels", kHdrVdp3MinSidePx));
  const auto require_light = [](const RgbImage& image, const char* what) {
    require_valid_radiance(image, what);
    if (cv::countNonZero(image.pixels.reshape(1)) == 0)
      throw ArgumentError(fmt::format("{} is black everywhere", what),
                          "give absolute light in cd/m^2; a display's black is above 0");
  };
  require_light(test, "the test image");
  require_light(reference, "the reference image");
}

/// 1 where a channel differs by more than 0.1 % of the reference.
cv::Mat1d difference_mask(const RgbImage& test, const RgbImage& reference) {
  return make_plane(test.pixels.size(), [&](int r, int c) {
    const cv::Vec3d t = test.pixels(r, c), s = reference.pixels(r, c);
    for (int k = 0; k < 3; ++k)
      if (std::abs(t[k] - s[k]) > 1e-3 * s[k]) return 1;
    return 0;
  });
}

struct Channels {
  std::vector<cv::Mat1d> bands;
  cv::Mat1d adaptation_cd_m2;
};

Channels see(const RgbImage& image, const VisualPathway& pathway, int levels) {
  const VisualResponse response = pathway(image);
  Channels out{steerable_bands(response.response_jnd, levels), response.adaptation_cd_m2};
  out.bands.back() -= cv::mean(out.bands.back());
  return out;
}

}  // namespace

HdrVdp3Result hdr_vdp3(const RgbImage& test, const RgbImage& reference,
                       const HdrVdp3Options& options) {
  require_comparable(test, reference, options);
  const double ppd = options.pixels_per_degree;
  const cv::Size size = test.pixels.size();
  const int levels = steerable_levels(size, ppd);

  Channels seen_test, seen_reference;
  {
    const VisualPathway pathway(size, ppd, options.spectra);  // as large as the image
    seen_test = see(test, pathway, levels);
    seen_reference = see(reference, pathway, levels);
  }
  cv::Mat1d& adaptation = seen_test.adaptation_cd_m2;
  fill_plane(adaptation, [&](int r, int c) {
    return std::log10((adaptation(r, c) + seen_reference.adaptation_cd_m2(r, c)) / 2);
  });
  seen_reference.adaptation_cd_m2.release();
  const BandDifferences differences =
      visible_difference(std::move(seen_test.bands), seen_reference.bands, adaptation,
                         difference_mask(test, reference), ppd);
  seen_reference.bands.clear();
  const Detection detection = detect(differences, ppd);

  HdrVdp3Result out;
  out.q_err = differences.q_err;
  out.q = 10 - std::log1p(std::exp(4) * out.q_err);  // 6 - ln(e^-4 + q_err)
  out.q_jod = 10 - 0.52 * std::pow(10 - out.q, 1.2812);
  // The offset that keeps log(0) away makes the published probability -1e-4 where nothing differs.
  out.p_det = std::clamp(detection.p_det, 0.0, 1.0);
  out.c_max = detection.c_max;
  out.detection_probability = ScalarImage(size.width, size.height);
  cv::Mat1d(cv::max(cv::min(detection.probability, 1), 0))
      .convertTo(out.detection_probability.pixels, CV_32F);
  return out;
}

}  // namespace wheatstone
