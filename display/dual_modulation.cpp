#include "display/dual_modulation.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kSupportSigmas = 4;     // 6e-5 of a lobe lies beyond
constexpr double kCoreEnergy = 0.95;     // share of the PSF inside the always-dilated core
constexpr double kClipTolerance = 1e-3;  // relative; below half a code at either end

struct Response {
  double black, gamma;

  double factor(double code) const {
    return black + (1 - black) * std::pow(std::clamp(code / 255, 0.0, 1.0), gamma);
  }
  /// Unrounded code 0..255 of a factor.
  double code(double f) const {
    return 255 * std::pow(std::clamp((f - black) / (1 - black), 0.0, 1.0), 1 / gamma);
  }
  std::array<double, 256> table() const {
    std::array<double, 256> t;
    for (int i = 0; i < 256; ++i) t[i] = factor(i);
    return t;
  }
};
Response lcd_response(const PanelModel& m) {
  return {m.lcd_black, m.lcd_gamma};
}
Response projector_response(const PanelModel& m) {
  return {m.projector_black, m.projector_gamma};
}

int lobe_radius(const GaussianLobe& l) {
  return static_cast<int>(std::ceil(kSupportSigmas * l.sigma_lcd_px));
}
int psf_radius(const PanelModel& m) {
  int r = 0;
  for (const auto& l : m.psf) r = std::max(r, lobe_radius(l));
  return r;
}

void require(bool ok, const char* what) {
  if (!ok)
    throw ArgumentError(std::string("the panel model is impossible: ") + what,
                        "calibrate the panel again or correct its file");
}

void check_panel(const PanelModel& m) {
  const auto side = [](int v) { return v > 0 && v <= 16384; };
  require(side(m.lcd_width_px) && side(m.lcd_height_px), "LCD size is not 1..16384 px");
  require(side(m.projector_width_px) && side(m.projector_height_px),
          "projector size is not 1..16384 px");
  require(m.H_lcd_projector.allFinite() && std::abs(m.H_lcd_projector.determinant()) > 1e-12,
          "H_lcd_projector has no inverse");
  require(std::isfinite(m.peak_cd_m2) && m.peak_cd_m2 > 0, "peak is not above 0 cd/m^2");
  require(std::isfinite(m.leak_cd_m2) && m.leak_cd_m2 >= 0, "leak is negative");
  for (const double black : {m.lcd_black, m.projector_black})
    require(black >= 0 && black < 1, "a black level is not in [0, 1)");
  for (const double gamma : {m.lcd_gamma, m.projector_gamma})
    require(gamma > 0.1 && gamma < 10, "a gamma is not in 0.1..10");
  require(!m.psf.empty(), "the PSF has no lobe");
  double sum = 0;
  for (const auto& l : m.psf) {
    require(l.sigma_lcd_px >= 0 && l.sigma_lcd_px < 512, "a PSF lobe's sigma is not in 0..512 px");
    require(l.weight >= 0, "a PSF lobe's weight is negative");
    sum += l.weight;
  }
  require(std::abs(sum - 1) < 1e-3, "the PSF weights do not sum to 1");
}

void require_size(const cv::Mat& image, int width, int height, int type, const char* what) {
  if (image.cols != width || image.rows != height || image.type() != type)
    throw ArgumentError(std::string(what) + " is " + std::to_string(image.cols) + " x " +
                            std::to_string(image.rows) + " x " + std::to_string(image.channels()) +
                            ", the panel has " + std::to_string(width) + " x " +
                            std::to_string(height) + " x " + std::to_string(CV_MAT_CN(type)),
                        "give an image of the panel's own size and type");
}

/// For each pixel of the LCD grid padded by `pad`: f(row, column, u, v) with its place (u, v) in
/// projector pixels. Pixels at or beyond the horizon of the homography are skipped.
void for_each_in_projector(const PanelModel& m, int pad,
                           const std::function<void(int, int, double, double)>& f) {
  const Eigen::Matrix3d H = m.H_lcd_projector.inverse();
  const Eigen::Vector3d middle(0.5 * (m.lcd_width_px - 1), 0.5 * (m.lcd_height_px - 1), 1);
  const double sign = (H * middle).z() < 0 ? -1 : 1;
  for (int r = 0; r < m.lcd_height_px + 2 * pad; ++r) {
    for (int c = 0; c < m.lcd_width_px + 2 * pad; ++c) {
      const Eigen::Vector3d h = H * Eigen::Vector3d(c - pad, r - pad, 1);
      if (!(sign * h.z() > 1e-12)) continue;
      const double u = h.x() / h.z(), v = h.y() / h.z();
      if (u > -1 && v > -1 && u < m.projector_width_px && v < m.projector_height_px) f(r, c, u, v);
    }
  }
}

/// The four bilinear taps around (u, v) that lie inside the image.
template <class F>
void for_each_tap(int width, int height, double u, double v, F f) {
  const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
  const double a = u - x, b = v - y;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double w = (i ? a : 1 - a) * (j ? b : 1 - b);
      const int tx = x + i, ty = y + j;
      if (tx >= 0 && ty >= 0 && tx < width && ty < height && w > 1e-9) f(ty, tx, w);
    }
  }
}

/// Share of the PSF in the square of half side `radius`.
double energy_within(const PanelModel& m, int radius) {
  double sum = 0;
  for (const auto& l : m.psf) {
    const int full = lobe_radius(l);
    const auto k = gaussian_kernel(l.sigma_lcd_px, full);
    double line = 0;
    for (int i = -std::min(full, radius); i <= std::min(full, radius); ++i) line += k[full + i];
    sum += l.weight * line * line;
  }
  return sum;
}

cv::Mat1f dilated(const cv::Mat1f& image, int radius) {
  cv::Mat1f out;
  cv::dilate(image, out,
             cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1}));
  return out;
}

/// Projector factor wanted on the padded LCD grid, so that B >= target. Inside the PSF's core the
/// square root is dilated; energy e of the PSF then sees it, which suffices while sqrt(t) <= e.
/// Only brighter pixels also need light from the tail, so dark surroundings stay dark.
cv::Mat1f wanted_projector(const PanelModel& m, const cv::Mat1f& target, int pad) {
  int core = 0;
  while (core < pad && energy_within(m, core) < kCoreEnergy) ++core;
  const double e = energy_within(m, core);
  cv::Mat1f root = cv::Mat1f::zeros(target.rows + 2 * pad, target.cols + 2 * pad),
            tail = root.clone();
  bool any_tail = false;
  for (int y = 0; y < target.rows; ++y) {
    for (int x = 0; x < target.cols; ++x) {
      const double t = target(y, x), s = std::sqrt(t);
      root(y + pad, x + pad) = static_cast<float>(s);
      if (s > e && e < 1) {
        tail(y + pad, x + pad) = static_cast<float>(std::min(1.0, (t - e * s) / (1 - e)));
        any_tail = true;
      }
    }
  }
  root = dilated(root, core);
  if (any_tail) root = cv::max(root, dilated(tail, pad));
  return root;
}

/// LCD grid to projector grid by maxima: each projector pixel serves every LCD pixel it helps to
/// light, so the bilinear forward warp is nowhere below `wanted`.
cv::Mat1f to_projector_grid(const PanelModel& m, const cv::Mat1f& wanted, int pad) {
  const int w = m.projector_width_px, h = m.projector_height_px;
  cv::Mat1f p = cv::Mat1f::zeros(h, w);
  for_each_in_projector(m, pad, [&](int r, int c, double u, double v) {
    for_each_tap(w, h, u, v,
                 [&](int y, int x, double) { p(y, x) = std::max(p(y, x), wanted(r, c)); });
  });
  // A projector finer than the LCD has pixels that no LCD pixel centre falls next to.
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const Eigen::Vector3d q = m.H_lcd_projector * Eigen::Vector3d(x, y, 1);
      const double cx = q.x() / q.z() + pad, cy = q.y() / q.z() + pad;
      if (!(cx > -0.5 && cy > -0.5 && cx < wanted.cols - 0.5 && cy < wanted.rows - 0.5)) continue;
      p(y, x) = std::max(
          p(y, x), wanted(static_cast<int>(std::lround(cy)), static_cast<int>(std::lround(cx))));
    }
  }
  return p;
}

ScalarImage factor_image(const PanelModel& m, const cv::Mat& projector_codes) {
  const auto table = projector_response(m).table();
  ScalarImage p(projector_codes.cols, projector_codes.rows);
  for (int y = 0; y < p.height(); ++y)
    for (int x = 0; x < p.width(); ++x)
      p.pixels(y, x) = static_cast<float>(table[projector_codes.at<uchar>(y, x)]);
  return p;
}

/// Code of LCD factor `f` at one pixel; `table` is the response of every code.
uchar lcd_code(const Response& r, const std::array<double, 256>& table, double f, LcdRounding how,
               int x, int y) {
  static constexpr int kBayer[4][4] = {
      {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  const double code = r.code(f);
  const int low = std::min(254, static_cast<int>(code));
  const double share = (std::clamp(f, table[0], 1.0) - table[low]) / (table[low + 1] - table[low]);
  const double threshold = how == LcdRounding::kNearest ? 0.5 : (kBayer[y & 3][x & 3] + 0.5) / 16;
  return static_cast<uchar>(low + (share > threshold));
}

}  // namespace

std::vector<double> gaussian_kernel(double sigma_px, int radius_px) {
  if (!(sigma_px >= 0) || radius_px < 0)
    throw ArgumentError("a Gaussian needs sigma >= 0 and radius >= 0", "check the PSF");
  std::vector<double> k(2 * static_cast<std::size_t>(radius_px) + 1, 0.0);
  double sum = 0;
  for (int i = -radius_px; i <= radius_px; ++i)
    sum += k[i + radius_px] =
        sigma_px > 0 ? std::exp(-0.5 * i * i / (sigma_px * sigma_px)) : (i == 0 ? 1.0 : 0.0);
  for (double& v : k) v /= sum;
  return k;
}

cv::Mat1d convolve_separable(const cv::Mat1d& image, std::span<const double> kernel) {
  if (image.empty() || kernel.size() % 2 == 0)
    throw ArgumentError("convolution needs an image and an odd kernel", "check both sizes");
  const cv::Mat1d k(std::vector<double>(kernel.begin(), kernel.end()), true);
  cv::Mat1d out;
  cv::sepFilter2D(image, out, CV_64F, k, k, {-1, -1}, 0, cv::BORDER_CONSTANT);
  return out;
}

SqrtSplit split_sqrt(const cv::Mat1d& target, std::span<const double> kernel, double lcd_black) {
  SqrtSplit s;
  cv::sqrt(target, s.projector);
  s.backlight = convolve_separable(s.projector, kernel);
  s.lcd.create(target.size());
  for (int y = 0; y < target.rows; ++y)
    for (int x = 0; x < target.cols; ++x)
      s.lcd(y, x) = s.backlight(y, x) > 0
                        ? std::clamp(target(y, x) / s.backlight(y, x), lcd_black, 1.0)
                        : lcd_black;
  return s;
}

ScalarImage simulate_backlight(const PanelModel& m, const ScalarImage& projector_factor) {
  check_panel(m);
  const cv::Mat1f& p = projector_factor.pixels;
  require_size(p, m.projector_width_px, m.projector_height_px, CV_32FC1, "the projector image");
  for (const float v : p)
    if (!(v >= 0 && v <= 1.0001f))
      throw ArgumentError("a projector factor is outside 0..1", "apply the projector's response");

  const int pad = psf_radius(m);
  cv::Mat1f warped = cv::Mat1f::zeros(m.lcd_height_px + 2 * pad, m.lcd_width_px + 2 * pad);
  for_each_in_projector(m, pad, [&](int r, int c, double u, double v) {
    double sum = 0;
    for_each_tap(p.cols, p.rows, u, v, [&](int y, int x, double w) { sum += w * p(y, x); });
    warped(r, c) = static_cast<float>(sum);
  });
  cv::Mat1f blurred = cv::Mat1f::zeros(warped.size()), one;
  for (const auto& l : m.psf) {
    const cv::Mat1d k(gaussian_kernel(l.sigma_lcd_px, lobe_radius(l)), true);
    cv::sepFilter2D(warped, one, CV_32F, k, k, {-1, -1}, 0, cv::BORDER_CONSTANT);
    cv::scaleAdd(one, l.weight, blurred, blurred);
  }
  return ScalarImage(blurred(cv::Rect(pad, pad, m.lcd_width_px, m.lcd_height_px)).clone());
}

RgbImage simulate_light(const PanelModel& m, const DriveImage& projector, const DriveImage& lcd) {
  check_panel(m);
  require_size(projector.codes, m.projector_width_px, m.projector_height_px, CV_8UC1,
               "the projector drive");
  require_size(lcd.codes, m.lcd_width_px, m.lcd_height_px, CV_8UC3, "the LCD drive");
  const ScalarImage backlight = simulate_backlight(m, factor_image(m, projector.codes));
  const auto table = lcd_response(m).table();
  RgbImage light(m.lcd_width_px, m.lcd_height_px);
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x)
      for (int c = 0; c < 3; ++c)
        light.pixels(y, x)[c] = static_cast<float>(
            m.peak_cd_m2 * table[lcd.codes.at<cv::Vec3b>(y, x)[c]] * backlight.pixels(y, x) +
            m.leak_cd_m2);
  return light;
}

DualDrive split_dual_modulation(const PanelModel& m, const RgbImage& target_cd_m2,
                                LcdRounding rounding) {
  check_panel(m);
  require_size(target_cd_m2.pixels, m.lcd_width_px, m.lcd_height_px, CV_32FC3, "the target");
  require_valid_radiance(target_cd_m2, "the target of a display");

  cv::Mat1f brightest(m.lcd_height_px, m.lcd_width_px);
  for (int y = 0; y < brightest.rows; ++y) {
    for (int x = 0; x < brightest.cols; ++x) {
      const cv::Vec3f& t = target_cd_m2.pixels(y, x);
      const double most = (std::max({t[0], t[1], t[2]}) - m.leak_cd_m2) / m.peak_cd_m2;
      brightest(y, x) = static_cast<float>(std::clamp(most, 0.0, 1.0));
    }
  }
  const int pad = psf_radius(m);
  const cv::Mat1f wanted = to_projector_grid(m, wanted_projector(m, brightest, pad), pad);

  DualDrive d;
  d.projector.codes.create(wanted.size(), CV_8UC1);
  const Response projector = projector_response(m);
  for (int y = 0; y < wanted.rows; ++y)
    for (int x = 0; x < wanted.cols; ++x)  // rounded up: too little light cannot be repaired
      d.projector.codes.at<uchar>(y, x) =
          static_cast<uchar>(std::min(255.0, std::ceil(projector.code(wanted(y, x)) - 1e-3)));

  const ScalarImage backlight = simulate_backlight(m, factor_image(m, d.projector.codes));
  const Response lcd = lcd_response(m);
  const auto table = lcd.table();
  d.lcd.codes.create(m.lcd_height_px, m.lcd_width_px, CV_8UC3);
  d.light_cd_m2 = RgbImage(m.lcd_width_px, m.lcd_height_px);
  for (int y = 0; y < m.lcd_height_px; ++y) {
    for (int x = 0; x < m.lcd_width_px; ++x) {
      const double full = m.peak_cd_m2 * backlight.pixels(y, x);
      bool above = false, below = false;
      for (int c = 0; c < 3; ++c) {
        const double target = target_cd_m2.pixels(y, x)[c];
        const double wanted_light = std::max(0.0, target - m.leak_cd_m2);
        above |= target > (full + m.leak_cd_m2) * (1 + kClipTolerance);
        below |= target < (full * m.lcd_black + m.leak_cd_m2) * (1 - kClipTolerance);
        const double f = full > 0 ? wanted_light / full : 0;
        const uchar code = lcd_code(lcd, table, f, rounding, x, y);
        d.lcd.codes.at<cv::Vec3b>(y, x)[c] = code;
        d.light_cd_m2.pixels(y, x)[c] = static_cast<float>(full * table[code] + m.leak_cd_m2);
      }
      d.above_peak_px += above;
      d.below_black_px += below;
    }
  }
  return d;
}

}  // namespace wheatstone
