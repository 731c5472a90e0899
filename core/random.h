#pragma once
// Counter-based random numbers: a value depends on (seed, stream, counter) alone, so results do
// not depend on the number of threads or the order of work.

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>

namespace wheatstone {

/// One reproducible stream. Distinct (seed, stream) pairs are independent for our purposes.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream)
      : state_(mix(mix(seed + 0x9e3779b97f4a7c15ULL) ^ (stream * 0xd1342543de82ef95ULL + 1))) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ULL;
    return mix(state_);
  }
  /// Uniform on (0, 1): never exactly 0 or 1.
  double uniform() { return (static_cast<double>(next() >> 12) + 0.5) * 0x1p-52; }
  /// Standard normal (Box-Muller, one of the pair kept for the next call).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double r = std::sqrt(-2.0 * std::log(uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = r * std::sin(angle);
    has_spare_ = true;
    return r * std::cos(angle);
  }
  /// Poisson count of the given mean >= 0: exact inversion below 30, above that the normal
  /// approximation rounded to an integer (its skew error there is below 4 % of sigma).
  double poisson(double mean);

 private:
  friend std::uint64_t stream_of(std::initializer_list<std::uint64_t>);
  // SplitMix64's finaliser (Steele, Lea, Flood 2014).
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// One stream for each combination of numbers.
inline std::uint64_t stream_of(std::initializer_list<std::uint64_t> numbers) {
  std::uint64_t stream = 0;
  for (const std::uint64_t n : numbers) stream = RandomStream::mix(stream + n + 1);
  return stream;
}

}  // namespace wheatstone
