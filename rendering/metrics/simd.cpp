#include "rendering/metrics/simd.h"

namespace wheatstone {

const std::vector<Simd>& available_simd() {
  static const std::vector<Simd> levels = [] {
    std::vector<Simd> out = {Simd::kPortable};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) out.push_back(Simd::kAvx2);
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("avx512f"))
      out.push_back(Simd::kAvx512);
#endif
    return out;
  }();
  return levels;
}

}  // namespace wheatstone
