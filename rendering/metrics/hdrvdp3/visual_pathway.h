#pragma once
// From light on the screen to one response of the eye: glare, receptors, adaptation, pupil.
// Source: HDR-VDP-3 (reference metrics.md, section 4, steps 1 to 5).

#include "core/image.h"
#include "rendering/metrics/hdrvdp3/eye_optics.h"

namespace wheatstone {

enum class DisplaySpectra;

struct VisualResponse {
  cv::Mat1d response_jnd;      // cones and rods together, in just noticeable differences
  cv::Mat1d adaptation_cd_m2;  // local luminance that the receptors are adapted to
};

/// The pathway for images of one size, seen at one resolution by an observer of age 24.
class VisualPathway {
 public:
  VisualPathway(cv::Size, double pixels_per_degree, DisplaySpectra);
  /// Pre: an image of the constructor's size, valid radiance.
  VisualResponse operator()(const RgbImage&) const;

 private:
  EyeGlare glare_;
  double pixels_per_degree_;
  DisplaySpectra spectra_;
};

}  // namespace wheatstone
