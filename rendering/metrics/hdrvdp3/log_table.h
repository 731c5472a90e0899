#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace wheatstone {

/// A function of a positive quantity x, sampled evenly in log10 x over 1e-5..1e5: linear between
/// the samples, constant outside.
class LogTable {
 public:
  /// Pre: at least two samples.
  explicit LogTable(std::vector<double> samples) : samples_(std::move(samples)) {}

  /// The x that belongs to each of `count` samples.
  static std::vector<double> abscissae(int count) {
    std::vector<double> x;
    for (int i = 0; i < count; ++i)
      x.push_back(std::pow(10, kMinLog10 + i * (kMaxLog10 - kMinLog10) / (count - 1)));
    return x;
  }

  double operator()(double log10_x) const {
    const auto last = static_cast<double>(samples_.size() - 1);
    const double position =
        (std::clamp(log10_x, kMinLog10, kMaxLog10) - kMinLog10) * (last / (kMaxLog10 - kMinLog10));
    const auto i = static_cast<std::size_t>(std::min(position, last - 1));
    return samples_[i] + (position - static_cast<double>(i)) * (samples_[i + 1] - samples_[i]);
  }

 private:
  static constexpr double kMinLog10 = -5, kMaxLog10 = 5;
  std::vector<double> samples_;
};

}  // namespace wheatstone
