#pragma once
// CaMoJAB: the content-adaptive model of judder, aliasing and blur. It predicts how the spectrum of
// a texture suffers from mip mapping, reduced shading rates, limited refresh rate and eye motion.
// Source: thesis (UCAM-CL-TR-977), chapter 5, appendices A and B; A. Jindal et al., "Perceptual
// model for adaptive local shading and refresh rate", ACM TOG 40(6), 2021.
//
// Spectra have 512 x 512 bins, k = -256..255 along each axis, spaced ppd / 512 cpd.

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <vector>

#include "rendering/motion_quality/fixed_power.h"
#include "rendering/motion_quality/preset.h"

namespace wheatstone {

inline constexpr int kCamojabSize = 512;
using CamojabSpectrum =
    Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;  // [ky][kx]

/// The spectrum of one texture, computed once; copies share it.
class CamojabTexture {
 public:
  /// grey: [row][column], values as stored (0..1), not linearised. One texel is one pixel; what
  /// exceeds 512 x 512 texels is cut off at the right and bottom, what lacks is 0.
  /// Errors: ArgumentError for an empty texture, or NaN and infinity (first place named).
  explicit CamojabTexture(const cv::Mat1d& grey);

  /// |DFT|, not normalised, zero frequency at [256][256].
  const CamojabSpectrum& amplitude() const { return *amplitude_; }

 private:
  std::shared_ptr<const CamojabSpectrum> amplitude_;
};

struct CamojabConditions {
  double ppd = 0;                                 // pixels per degree, > 0
  double refresh_hz = 0;                          // > 0
  double speed_deg_per_s = 0;                     // along x, >= 0
  double persistence = 1;                         // lit part of the frame, (0, 1]
  double luminance_cd_m2 = 0;                     // mean, > 0
  double mip_level = 0;                           // >= 0, fractions allowed
  double shading_rate_x = 1, shading_rate_y = 1;  // of full resolution, (0, 1]
};

/// Errors: ArgumentError naming the value outside its range; `where`, such as a file and line
/// followed by ": ", begins the message.
void require_valid(const CamojabConditions&, const std::string& where = "");

/// quality is in model units, 0 at best for Ds, Dt >= 0: JND only after the multiplier of the
/// experiment one compares with (see fitting.h).
struct CamojabQuality {
  double spatial_distortion = 0;   // Ds: sharpness lost or false detail gained
  double temporal_distortion = 0;  // Dt: visible aliases of motion
  double quality = 0;              // Q = ws Ds + wt Dt
};

/// Weights of the two distortions and the exponent of energy (thesis, table 5.2).
struct CamojabWeights {
  double spatial = -3.698530942720978, temporal = -2.906819337217838;
  double beta = 0.359663511318103;  // (0, 4]
};
inline constexpr double kCamojabMaxBeta = 4;

/// Everything about the model that has been varied: where thesis and released program differ, and
/// which stages take part (for ablation, table 5.4).
struct CamojabModel {
  enum class Radius { kLargerAxis, kEuclidean };  // of a bin's two frequencies, for the sensitivity
  enum class Comb { kHalfIntervalOneSide, kFullIntervalOneSide, kFullIntervalTwoSides };

  Radius radius = Radius::kLargerAxis;
  Comb comb = Comb::kHalfIntervalOneSide;
  double alias_position = 0.5;  // of the first alias of motion, in refresh_hz / speed
  bool mip_blur = true, aliasing = true, clipping = true, judder = true;
  bool hold_blur = true, eye_blur = true;  // the two parts of motion blur
  CamojabWeights weights;

  /// kPublished: Euclidean radius, replicas at the full interval on both sides, alias at
  /// refresh_hz / speed; everything else as kReleased, the weights included.
  static CamojabModel preset(MotionQualityPreset);
};

/// Energies mean(X^beta) after each stage; "weighted" with S(rho, 0, L) first. For tests, plots and
/// whoever wants to see where quality is lost.
struct CamojabStages {
  double reference = 0, reference_weighted = 0;
  double mip_blur = 0, mip_blur_weighted = 0;
  double aliasing_weighted = 0, clipping_weighted = 0, motion_blur_weighted = 0;
  int alias_shift_bins = 0;  // of 512: from there on, the alias lies outside the spectrum
  CamojabQuality result;
};

/// The model for one texture.
class Camojab {
 public:
  /// Errors: ArgumentError for beta outside (0, 4] or an alias position that is not positive.
  explicit Camojab(CamojabTexture,
                   CamojabModel = CamojabModel::preset(MotionQualityPreset::kReleased));
  const CamojabModel& model() const { return model_; }

  /// Errors: ArgumentError naming the condition that is outside its range.
  CamojabQuality evaluate(const CamojabConditions&) const;
  /// The same numbers for many conditions, in parallel; those that share mip level and shading
  /// rates share most of the work. Errors also name the index of the conditions.
  std::vector<CamojabQuality> evaluate(std::span<const CamojabConditions>) const;

  /// The model stage by stage on whole spectra, without any shortcut (slow).
  CamojabStages stages(const CamojabConditions&) const;

 private:
  CamojabTexture texture_;
  CamojabModel model_;
  FixedPower power_;
  CamojabSpectrum reference_energy_;  // folded, see camojab.cpp
};

}  // namespace wheatstone
