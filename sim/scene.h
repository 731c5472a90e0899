#pragma once
// The real box: geometry, textures and light, traced with Embree. Light is one bounce from the
// LEDs to the surface to the eye; black walls make further bounces negligible.

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace wheatstone {

/// What is switched on in the box.
struct BoxLight {
  double led_drive = 0;      // mean of all ceiling LEDs, linear, 0..1: they shine as one white lamp
  unsigned marker_mask = 0;  // bit i: marker i is lit
  friend bool operator==(const BoxLight&, const BoxLight&) = default;
};

/// A ray in rsb, mm. The direction need not have unit length.
struct Ray {
  Eigen::Vector3f origin, direction;
};

inline constexpr int kMarkerCount = 4;
inline constexpr double kMarkerRadiusMm = 0.4;
inline constexpr double kMarkerCdM2 = 600;     // 0.6 of saturation at 1/60 s
inline constexpr double kCardWhiteCdM2 = 400;  // Lambertian white at the card's centre, drive 1
inline const Eigen::Vector3d kBoxSizeMm(370, 260, 360);

std::array<Eigen::Vector3d, kMarkerCount> marker_positions_rsb_mm();
const std::vector<std::string>& scene_names();

/// Safe to use from many threads. The irradiance of the surfaces is baked when a ray meets the
/// ceiling's light for the first time: most rigs never look at their box.
class Scene {
 public:
  static constexpr int kPacket = 8;

  /// Throws ArgumentError for an unknown name.
  explicit Scene(const std::string& name);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Linear BT.709 radiance in cd/m^2 along each of 1..kPacket rays; 0 where a ray leaves the box.
  void radiance(const Ray* rays, int count, const BoxLight&, Eigen::Vector3f* rgb_cd_m2) const;
  Eigen::Vector3f radiance(const Ray&, const BoxLight&) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheatstone
