#include "calib/markers.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kDetectionSigmas = 8;
constexpr int kWindowBorderPx = 3;  // the window reaches this far beyond the component
constexpr int kRingPx = 2;          // width of the background ring outside the window
constexpr int kMinBoxArea = 9;      // a hot photosite covers 4 of the 2x2 box image

double median(std::vector<float> v) {
  const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// A frame prepared for measuring: values above black, divided by the response to white.
struct Balanced {
  cv::Mat1f value, variance;  // DN, DN^2
  cv::Mat1f box;              // mean of the 2x2 cell that starts here; centre at (+0.5, +0.5)
  double dark_box_sigma = 0;
};

// A centroid on the raw mosaic is biased when the colours respond unequally, because each colour
// samples the blob on its own grid. Dividing by the response to white removes the modulation for
// white light. Estimating the tint from the blob itself is worse: on a sharp disc of 4 px each
// colour's sum is as much in doubt as the tint of a white LED.
Balanced balance(const MosaicImage& frame, const CameraProfile& camera) {
  Eigen::Vector3d white = camera.camera_from_bt709 * Eigen::Vector3d::Ones();
  if (!(white.minCoeff() > 0))
    throw ArgumentError("the camera profile gives white light no response in some colour",
                        "check camera_from_bt709");
  white /= white.mean();
  Balanced b;
  b.value.create(frame.dn.size());
  b.variance.create(frame.dn.size());
  double dark_variance = 0;
  for (int r = 0; r < frame.height(); ++r)
    for (int c = 0; c < frame.width(); ++c) {
      const int colour = bayer_colour(frame.pattern, r, c);
      const double k = camera.dn_per_electron[static_cast<std::size_t>(colour)];
      const double dn = double(frame.dn(r, c)) - camera.black_dn;
      const double floor_variance =
          (camera.read_noise_e * camera.read_noise_e + camera.adc_noise * camera.adc_noise) * k *
              k +
          1.0 / 12;  // rounding to whole DN
      const double gain = 1 / white[colour];
      b.value(r, c) = static_cast<float>(dn * gain);
      b.variance(r, c) = static_cast<float>((std::max(dn, 0.0) * k + floor_variance) * gain * gain);
      if (r < 2 && c < 2) dark_variance += floor_variance * gain * gain / 16;
    }
  b.dark_box_sigma = std::sqrt(dark_variance);
  cv::boxFilter(b.value, b.box, CV_32F, {2, 2}, {0, 0});
  b.box = b.box(cv::Rect(0, 0, frame.width() - 1, frame.height() - 1));
  return b;
}

double detection_threshold(const Balanced& b) {
  std::vector<float> sample;
  for (int r = 0; r < b.box.rows; r += 3)
    for (int c = 0; c < b.box.cols; c += 3) sample.push_back(b.box(r, c));
  const double background = median(sample);
  for (float& v : sample) v = std::abs(v - static_cast<float>(background));
  const double sigma = 1.4826 * median(std::move(sample));
  return background + kDetectionSigmas * std::max(sigma, b.dark_box_sigma);
}

/// Median of the box image in the ring around `window`; on the box image every value holds all
/// colours, so a tinted background does no harm.
double ring_background(const Balanced& b, const cv::Mat1i& labels, const cv::Rect& window) {
  const cv::Rect all(0, 0, b.box.cols, b.box.rows);
  const cv::Rect outer = cv::Rect(window.x - kRingPx, window.y - kRingPx,
                                  window.width + 2 * kRingPx, window.height + 2 * kRingPx) &
                         all;
  std::vector<float> ring;
  for (int r = outer.y; r < outer.br().y; ++r)
    for (int c = outer.x; c < outer.br().x; ++c)
      if (!window.contains({c, r}) && labels(r, c) == 0) ring.push_back(b.box(r, c));
  return ring.empty() ? 0.0 : median(std::move(ring));
}

MarkerBlob measure(const Balanced& b, const cv::Mat1i& labels, int label, const cv::Rect& bounds) {
  // A box of the component covers one photosite more than its index on each axis.
  const cv::Rect window =
      cv::Rect(bounds.x - kWindowBorderPx, bounds.y - kWindowBorderPx,
               bounds.width + 1 + 2 * kWindowBorderPx, bounds.height + 1 + 2 * kWindowBorderPx) &
      cv::Rect(0, 0, b.value.cols, b.value.rows);
  const double background = ring_background(b, labels, window);
  const auto visit = [&](auto&& f) {
    for (int r = window.y; r < window.br().y; ++r)
      for (int c = window.x; c < window.br().x; ++c) {
        const int owner = labels(std::min(r, labels.rows - 1), std::min(c, labels.cols - 1));
        if (owner == 0 || owner == label)  // a neighbour's light does not count
          f(Eigen::Vector2d(c, r), b.value(r, c) - background, double(b.variance(r, c)));
      }
  };
  MarkerBlob blob;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  visit([&](const Eigen::Vector2d& p, double v, double) {
    blob.signal_dn += v;
    moment += v * p;
  });
  if (!(blob.signal_dn > 0)) return blob;
  blob.centroid_px = moment / blob.signal_dn;
  visit([&](const Eigen::Vector2d& p, double, double v) {
    const Eigen::Vector2d lever = p - blob.centroid_px;
    blob.covariance_px2 += v / (blob.signal_dn * blob.signal_dn) * lever * lever.transpose();
  });
  return blob;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

std::vector<MarkerBlob> find_markers(const MosaicImage& frame, const CameraProfile& camera) {
  if (frame.width() < 8 || frame.height() < 8)
    throw ArgumentError("a frame of " + std::to_string(frame.width()) + " x " +
                            std::to_string(frame.height()) + " px is too small to hold markers",
                        "take a full frame");
  const Balanced b = balance(frame, camera);
  const cv::Mat1b bright = b.box > detection_threshold(b);
  cv::Mat1i labels;
  cv::Mat stats, centroids;
  const int count = cv::connectedComponentsWithStats(bright, labels, stats, centroids, 8, CV_32S);
  std::vector<MarkerBlob> blobs;
  for (int i = 1; i < count; ++i) {
    const int area = stats.at<int>(i, cv::CC_STAT_AREA);
    if (area < kMinBoxArea) continue;
    MarkerBlob blob =
        measure(b, labels, i,
                {stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                 stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT)});
    blob.area_px = area;
    if (blob.signal_dn > 0) blobs.push_back(blob);
  }
  std::stable_sort(blobs.begin(), blobs.end(), [](const MarkerBlob& x, const MarkerBlob& y) {
    return x.signal_dn > y.signal_dn;
  });
  return blobs;
}

std::array<MarkerBlob, 4> order_markers(std::span<const MarkerBlob> blobs,
                                        const std::string& what) {
  if (blobs.size() < 4)
    throw ArgumentError(what + ": found " + std::to_string(blobs.size()) + " of 4 marker LEDs",
                        "switch all four LEDs on, darken the room, free the view to them or "
                        "expose longer, and take the frame again");
  std::vector<MarkerBlob> strongest(blobs.begin(), blobs.end());
  std::partial_sort(
      strongest.begin(), strongest.begin() + 4, strongest.end(),
      [](const MarkerBlob& a, const MarkerBlob& b) { return a.signal_dn > b.signal_dn; });
  std::array<MarkerBlob, 4> p;
  std::copy_n(strongest.begin(), 4, p.begin());
  const auto x = [](const MarkerBlob& b) { return b.centroid_px.x(); };
  // Image rows go down: the two largest y are the bottom markers.
  std::sort(p.begin(), p.end(), [](const MarkerBlob& a, const MarkerBlob& b) {
    return a.centroid_px.y() > b.centroid_px.y();
  });
  if (x(p[0]) > x(p[1])) std::swap(p[0], p[1]);
  if (x(p[2]) > x(p[3])) std::swap(p[2], p[3]);
  const std::array<Eigen::Vector2d, 4> ring = {p[0].centroid_px, p[2].centroid_px, p[3].centroid_px,
                                               p[1].centroid_px};  // clockwise
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d a = ring[(i + 1) % 4] - ring[i];
    const Eigen::Vector2d b = ring[(i + 2) % 4] - ring[(i + 1) % 4];
    if (!(cross(a, b) > 0.05 * a.norm() * b.norm()))
      throw ArgumentError(what + ": the four brightest spots do not form the markers' rectangle",
                          "remove reflections and other lights, or check that all four LEDs "
                          "are on, and take the frame again");
  }
  return p;
}

}  // namespace wheatstone
