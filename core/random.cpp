#include "core/random.h"

namespace wheatstone {

double RandomStream::poisson(double mean) {
  if (!(mean > 0)) return 0;
  if (mean > 30) return std::max(0.0, std::round(mean + std::sqrt(mean) * normal()));
  const double limit = std::exp(-mean);
  double product = uniform();
  double count = 0;
  while (product > limit) {
    product *= uniform();
    count += 1;
  }
  return count;
}

}  // namespace wheatstone
