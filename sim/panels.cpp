#include "sim/panels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace wheatstone {
namespace {

constexpr double kPanelCentreXMm = 185, kPanelCentreYMm = 130;

std::array<float, 256> response(double black, double gamma) {
  std::array<float, 256> table;
  for (int d = 0; d < 256; ++d) {
    table[static_cast<std::size_t>(d)] =
        static_cast<float>(black + (1 - black) * std::pow(d / 255.0, gamma));
  }
  return table;
}

// Full-size map: the projector overfills the LCD by 3 %, turned and keystoned a little, and
// differently for each display.
Eigen::Matrix3d full_size_H_lcd_projector(DisplayId id) {
  const double sign = id.eye == Eye::kLeft ? 1 : -1;
  const double extra = id.plane == Plane::kFar ? 1 : 0;
  const double angle = sign * (0.25 + 0.1 * extra) * std::numbers::pi / 180;
  const double s = 2 * 1.03;
  Eigen::Matrix3d from_centre = Eigen::Matrix3d::Identity();
  from_centre.topRightCorner<2, 1>() = -Eigen::Vector2d(511.5, 383.5);
  Eigen::Matrix3d H;
  H << s * std::cos(angle), -s * std::sin(angle), 2.5 * sign,  //
      s * std::sin(angle), s * std::cos(angle), -1.5 + 2 * extra, 4e-6 * sign, -3e-6 + 2e-6 * extra,
      1;
  Eigen::Matrix3d to_lcd = Eigen::Matrix3d::Identity();
  to_lcd.topRightCorner<2, 1>() = Eigen::Vector2d(1023.5, 767.5);
  return to_lcd * H * from_centre;
}

// p(d) at LCD pixels (x - margin, y - margin), 0 outside the projector's image.
cv::Mat1f warped_projector(const PanelModel& m, const DriveImage& drive, int margin) {
  const auto p = response(m.projector_black, m.projector_gamma);
  cv::Mat1f source(m.projector_height_px, m.projector_width_px, p[0]);
  if (!drive.codes.empty()) {
    for (int y = 0; y < source.rows; ++y) {
      const std::uint8_t* codes = drive.codes.ptr<std::uint8_t>(y);
      for (int x = 0; x < source.cols; ++x) source(y, x) = p[codes[x]];
    }
  }
  const Eigen::Matrix3d H_projector_lcd = m.H_lcd_projector.inverse();
  const auto at = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < source.cols && y < source.rows ? source(y, x) : 0.0F;
  };
  cv::Mat1f out(m.lcd_height_px + 2 * margin, m.lcd_width_px + 2 * margin);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      const Eigen::Vector2d q =
          (H_projector_lcd * Eigen::Vector3d(x - margin, y - margin, 1)).hnormalized();
      const int i = static_cast<int>(std::floor(q.x())), j = static_cast<int>(std::floor(q.y()));
      const auto fx = static_cast<float>(q.x() - i), fy = static_cast<float>(q.y() - j);
      out(y, x) = (1 - fy) * ((1 - fx) * at(i, j) + fx * at(i + 1, j)) +
                  fy * ((1 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1));
    }
  }
  return out;
}

}  // namespace

Eigen::Vector3d true_eye_centre_rsb_mm(Eye eye) {
  return {kPanelCentreXMm + (eye == Eye::kLeft ? -31.5 : 31.5), kPanelCentreYMm, kEyeZMm};
}

double plane_z_rsb_mm(Plane plane) {
  return plane == Plane::kNear ? kNearPlaneZMm : kFarPlaneZMm;
}

PanelModel true_panel_model(DisplayId id, double scale) {
  const auto scaled = [&](int px) {
    return std::max(1, static_cast<int>(std::lround(px * scale)));
  };
  PanelModel m;
  m.id = id;
  m.distance = Length::of(kEyeZMm - plane_z_rsb_mm(id.plane));
  m.width_mm = kPanelWidthMm;
  m.height_mm = kPanelHeightMm;
  m.lcd_width_px = scaled(2048);
  m.lcd_height_px = scaled(1536);
  m.projector_width_px = scaled(1024);
  m.projector_height_px = scaled(768);
  Eigen::Matrix3d to_scaled;  // x_s = (x + 0.5) s - 0.5
  to_scaled << scale, 0, 0.5 * scale - 0.5, 0, scale, 0.5 * scale - 0.5, 0, 0, 1;
  m.H_lcd_projector = to_scaled * full_size_H_lcd_projector(id) * to_scaled.inverse();
  m.H_lcd_projector /= m.H_lcd_projector(2, 2);
  m.psf = {{std::max(0.7, 4 * scale), 0.95}, {std::max(0.7, 24 * scale), 0.05}};
  m.peak_cd_m2 = 3000;
  m.leak_cd_m2 = 0.005;
  m.lcd_black = 1.0 / 1000;
  m.projector_black = 1.0 / 2000;
  m.lcd_gamma = 2.2;
  m.projector_gamma = 2.0;
  return m;
}

Eigen::Vector2d lcd_px_at(const PanelModel& m, double x_mm, double y_mm) {
  return {((x_mm - kPanelCentreXMm) / m.width_mm + 0.5) * m.lcd_width_px - 0.5,
          ((kPanelCentreYMm - y_mm) / m.height_mm + 0.5) * m.lcd_height_px - 0.5};
}

RgbImage panel_light_cd_m2(const PanelModel& m, const DriveImage& lcd,
                           const DriveImage& projector) {
  // The image reaches beyond the LCD, and that light scatters back into it.
  double widest = 0;
  for (const GaussianLobe& lobe : m.psf) widest = std::max(widest, lobe.sigma_lcd_px);
  const int margin = static_cast<int>(std::ceil(4 * widest));
  const cv::Mat1f warped = warped_projector(m, projector, margin);
  cv::Mat1f backlight(warped.size(), 0.0F);
  for (const GaussianLobe& lobe : m.psf) {
    const int size = 2 * static_cast<int>(std::ceil(4 * lobe.sigma_lcd_px)) + 1;
    cv::Mat1f blurred;
    cv::GaussianBlur(warped, blurred, {size, size}, lobe.sigma_lcd_px, lobe.sigma_lcd_px,
                     cv::BORDER_CONSTANT);
    backlight += lobe.weight * blurred;
  }
  const auto transmission = response(m.lcd_black, m.lcd_gamma);
  const auto peak = static_cast<float>(m.peak_cd_m2), leak = static_cast<float>(m.leak_cd_m2);
  RgbImage out(m.lcd_width_px, m.lcd_height_px);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const cv::Vec3b codes =
          lcd.codes.empty() ? cv::Vec3b(0, 0, 0) : lcd.codes.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) {
        out.pixels(y, x)[c] =
            peak * transmission[codes[c]] * backlight(y + margin, x + margin) + leak;
      }
    }
  }
  return out;
}

}  // namespace wheatstone
