#include "rendering/metrics/pu21_rows.h"

#include "rendering/metrics/row_kernels.h"

namespace wheatstone::detail {

bool Pu21Source::encode(const cv::Vec3f* light_cd_m2, int count, float* pu21) const {
  bool valid = true;
  if (channel_ < 0)
    valid = luminance_row(light_cd_m2->val, count, pu21, simd_);
  else
    for (int i = 0; i < count; ++i) pu21[i] = light_cd_m2[i][channel_];
  return pu21_encode_span(table_, pu21, static_cast<std::size_t>(count), pu21, simd_) && valid;
}

}  // namespace wheatstone::detail
