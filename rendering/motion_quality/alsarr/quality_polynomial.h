#pragma once
// What a texture gains by a finer shading rate, as a polynomial of speed, refresh rate and
// luminance: CaMoJAB is far too slow to be asked for every tile of every frame. Source: thesis
// (UCAM-CL-TR-977), equation 6.10; reference motion_quality.md, section 4.

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "rendering/motion_quality/camojab.h"

namespace wheatstone {

/// q(v, f, L) = (W0 + W1 v + W2 f + W3 v^2 + W4 v f + W5 f^2) (W6 l^3 + W7 l^2 + W8 l + W9),
/// l = log10 L: quality above that of quarter rate, in CaMoJAB's model units.
struct QualityPolynomial {
  std::array<double, 10> w{};

  /// Pre: luminance_cd_m2 > 0.
  double operator()(double speed_deg_per_s, double refresh_hz, double luminance_cd_m2) const;
};

/// Two rates of one axis have a polynomial: 1/2 and 1. Quarter rate is 0 by definition.
enum class AxisRate { kHalf, kFull };

inline constexpr int kMipRows = 12;  // mip levels 0..11

/// Polynomials of the materials of a scene, for each mip level and rate.
class PolynomialTable {
 public:
  using MipRow = std::array<QualityPolynomial, 2>;  // [AxisRate]
  struct Material {
    std::string name;
    std::array<MipRow, kMipRows> mips;
  };
  explicit PolynomialTable(std::vector<Material> materials = {})
      : materials_(std::move(materials)) {}

  /// Columns material_index (from 1), material_name, rate (half, full), mip_index_1based (1..12),
  /// W0..W9. Errors: FileError naming file and line: a missing column, a cell that is no finite
  /// number, an index out of range, an unknown rate, a row given twice; a row that lacks.
  static PolynomialTable read(const std::filesystem::path&);
  /// The same table; atomic.
  void write(const std::filesystem::path&) const;

  int materials() const { return static_cast<int>(materials_.size()); }
  const Material& material(int index) const {
    return materials_.at(static_cast<std::size_t>(index));
  }
  /// Indices from 0; a mip level beyond the table has its last or first row's polynomial.
  const MipRow& at(int material, int mip_level) const;

 private:
  std::vector<Material> materials_;
};

/// One comparison with quarter rate, from which polynomials are fitted.
struct QualitySample {
  double refresh_hz = 0, speed_deg_per_s = 0, log10_luminance = 0;
  double gain = 0;  // quality above quarter rate, >= 0; what is below 1e-4 counts as 0
};

/// The first factor is the least-squares fit of the samples at the largest luminance, the second
/// runs through the gains at 105 Hz and speed 0 relative to that luminance's. All coefficients are
/// 0 where that gain is 0.
/// Errors: ArgumentError unless the samples cover the grid of kFitRefresh_hz and so on, below.
QualityPolynomial fit_quality_polynomial(std::span<const QualitySample>);

/// The samples of both rates ([AxisRate]) for a texture at one mip level, whole grid: 60 ppd,
/// persistence 1, the same rate on both axes. Runs in parallel; the same for any number of threads.
std::array<std::vector<QualitySample>, 2> sample_quality_gains(const Camojab&, double mip_level);

inline constexpr std::array<double, 7> kFitRefresh_hz = {30, 45, 60, 75, 90, 105, 120};
inline constexpr std::array<double, 6> kFitSpeed_deg_per_s = {0, 10, 20, 30, 40, 50};
inline constexpr std::array<double, 4> kFitLog10Luminance = {-1, 1, 2, 2.5};

}  // namespace wheatstone
