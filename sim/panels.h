#pragma once
// The four dual-modulation displays as they really are in the twin, and the light they give.

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

inline constexpr double kEyeZMm = 850;
inline constexpr double kNearPlaneZMm = 360, kFarPlaneZMm = 0;
inline constexpr double kPanelWidthMm = 197.0, kPanelHeightMm = 147.8;

Eigen::Vector3d true_eye_centre_rsb_mm(Eye);
double plane_z_rsb_mm(Plane);

/// The true display at `scale` of the full pixel size (2048x1536 LCD, 1024x768 projector).
PanelModel true_panel_model(DisplayId, double scale);

/// LCD pixel of a point on the panel's plane (x, y in rsb, mm).
Eigen::Vector2d lcd_px_at(const PanelModel&, double x_mm, double y_mm);

/// Light leaving the plane per LCD pixel, by the formula of PanelModel. An empty drive image is
/// all black. Pre: sizes and types fit the panel.
RgbImage panel_light_cd_m2(const PanelModel&, const DriveImage& lcd, const DriveImage& projector);

}  // namespace wheatstone
