#pragma once
// What a capture camera and a display are, as far as every layer needs to know it.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/image.h"
#include "core/units.h"

namespace wheatstone {

/// Noise of a sensor: electrons N ~ Poisson become Y = (N + n_read) g k + n_adc k DN at gain g =
/// ISO / 100, so that Var(Y) = x g k + (read_noise_e^2 g^2 + adc_noise^2) k^2 for x = E[Y], black
/// level subtracted (reference hdr_merge.md, sec. 1).
struct SensorNoise {
  std::array<double, 3> dn_per_electron = {1, 1, 1};  // k, of R, G, B at gain 1
  double read_noise_e = 0;                            // s_read [e-], before the amplifier
  double adc_noise = 0;                               // s_adc [in units of k DN], after it
};

/// Capture camera: geometry and radiometry. A photosite of colour c under light with camera-space
/// colour e_c = (camera_from_bt709 * rgb)_c in cd/m^2, exposed for t seconds at ISO 100, reads
///   DN = black_dn + dn_per_cd_m2_s * e_c * t   up to white_dn   (reference hdr_merge.md, sec. 1).
struct CameraProfile {
  std::string serial;
  Intrinsics intrinsics;
  Distortion distortion;
  BayerPattern pattern = BayerPattern::kRggb;
  int black_dn = 0, white_dn = 0;  // white_dn: the first saturated code
  double dn_per_cd_m2_s = 0;
  Eigen::Matrix3d camera_from_bt709 = Eigen::Matrix3d::Identity();
  std::array<double, 3> dn_per_electron = {1, 1, 1};  // k of the noise model, per colour
  double read_noise_e = 0, adc_noise = 0;             // s_read [e-], s_adc

  SensorNoise noise() const { return {dn_per_electron, read_noise_e, adc_noise}; }
};

enum class Eye { kLeft, kRight };
enum class Plane { kNear, kFar };
struct DisplayId {
  Eye eye = Eye::kLeft;
  Plane plane = Plane::kNear;
  friend bool operator==(const DisplayId&, const DisplayId&) = default;
};
inline constexpr std::array<DisplayId, 4> kDisplays = {
    DisplayId{Eye::kLeft, Plane::kNear}, DisplayId{Eye::kLeft, Plane::kFar},
    DisplayId{Eye::kRight, Plane::kNear}, DisplayId{Eye::kRight, Plane::kFar}};
std::string to_string(Eye);                         // "left", "right"
std::string to_string(Plane);                       // "near", "far"
std::string to_string(DisplayId);                   // "left_near", ...
DisplayId display_from_string(const std::string&);  // throws ArgumentError
inline int index_of(DisplayId d) {
  return (d.eye == Eye::kRight ? 2 : 0) + (d.plane == Plane::kFar);
}

/// One Gaussian of a point spread function; the weights of a PSF sum to 1.
struct GaussianLobe {
  double sigma_lcd_px = 0, weight = 0;
};

/// A dual-modulation display: an LCD (colour) lit from behind by a projector image (grey).
/// Light of colour c at LCD pixel x (reference dual_modulation.md, image formation):
///   L_c(x) = peak_cd_m2 * lcd_c(x) * (PSF * p_warped)(x) + leak_cd_m2
///   lcd(d) = lcd_black + (1 - lcd_black) (d/255)^lcd_gamma
///   p(d)   = projector_black + (1 - projector_black) (d/255)^projector_gamma
/// p_warped is p sampled bilinearly through H_lcd_projector, 0 outside the projector's image.
struct PanelModel {
  DisplayId id;
  Length distance;                     // eye to the plane along the optical axis
  double width_mm = 0, height_mm = 0;  // lit area
  int lcd_width_px = 0, lcd_height_px = 0;
  int projector_width_px = 0, projector_height_px = 0;
  Eigen::Matrix3d H_lcd_projector = Eigen::Matrix3d::Identity();  // homogeneous pixels
  std::vector<GaussianLobe> psf;
  double peak_cd_m2 = 0, leak_cd_m2 = 0;
  double lcd_black = 0, projector_black = 0, lcd_gamma = 2.2, projector_gamma = 2.2;
};

/// One aligned mark: the observer saw LCD pixel `lcd_px` on the point `p_rsb_mm`.
struct Alignment {
  Eigen::Vector3d p_rsb_mm;
  Eigen::Vector2d lcd_px;
};

/// How one eye sees one display: LCD pixel of any point of the box, P_pixel_rsb = K [R | t].
struct EyeDisplayCalibration {
  DisplayId id;
  Eigen::Matrix<double, 3, 4> P_lcd_rsb = Eigen::Matrix<double, 3, 4>::Zero();
  Intrinsics intrinsics;     // K from RQ, size of the LCD
  RigidTransform T_eye_rsb;  // R, t from RQ
  double rms_px = 0;
  std::vector<Eigen::Vector2d> residuals_px;  // predicted - aligned, one per mark
};

/// A posed pinhole view of a light field. `world` is `rsb` for captures of the box.
struct LightFieldView {
  std::string name;
  RgbImage light_cd_m2;
  Intrinsics intrinsics;
  RigidTransform T_camera_world;
};

/// A plane in the world: the points with normal . p = offset_mm. |normal| = 1.
struct PlaneInWorld {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_mm = 0;
};

}  // namespace wheatstone
