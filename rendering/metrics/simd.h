#pragma once
// Which vector instructions the metrics' inner loops may use on this processor. The choice changes
// the speed only: every level does the same operations in the same order, without fused
// multiply-add, and so gives the same bits.

#include <vector>

namespace wheatstone {

enum class Simd { kPortable, kAvx2, kAvx512 };

/// The levels that this processor runs, slowest first; never empty.
const std::vector<Simd>& available_simd();
inline Simd best_simd() {
  return available_simd().back();
}

}  // namespace wheatstone
