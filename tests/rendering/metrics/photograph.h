#pragma once
// The reference's HDR photograph on a display of 4000 cd/m^2, and two degradations of it, as
// nancy_church.json defines them.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "core/hdr_files.h"

namespace wheatstone {

struct Photograph {
  RgbImage reference, blur, contrast80;
};

inline Photograph degraded_photograph(const std::filesystem::path& file) {
  const auto shown = [](const cv::Mat3d& light) {
    RgbImage out(light.cols, light.rows);
    cv::Mat3d(cv::max(cv::min(light.reshape(1), 4000), 0.005))
        .reshape(3)
        .convertTo(out.pixels, CV_32F);
    return out;
  };
  cv::Mat3d rgb;
  read_radiance_hdr(file).pixels.convertTo(rgb, CV_64F, 4000 / 5344.0);  // the brightest sample
  rgb = cv::Mat(cv::max(cv::min(rgb.reshape(1), 4000), 0.005)).reshape(3);
  cv::Mat3d blur, contrast(rgb.size());
  cv::GaussianBlur(rgb, blur, {9, 9}, 2, 2, cv::BORDER_REPLICATE);
  cv::Mat log_light;
  cv::log(rgb, log_light);
  const cv::Scalar log_mean = cv::mean(log_light);
  for (int r = 0; r < rgb.rows; ++r)
    for (int c = 0; c < rgb.cols; ++c)
      for (int k = 0; k < 3; ++k) {
        const double m = std::exp(log_mean[k]);
        contrast(r, c)[k] = m * std::pow(rgb(r, c)[k] / m, 0.8);
      }
  return {shown(rgb), shown(blur), shown(contrast)};
}

}  // namespace wheatstone
