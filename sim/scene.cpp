#include "sim/scene.h"

#include <embree3/rtcore.h>
#include <tbb/collaborative_call_once.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "sim/surfaces.h"

namespace wheatstone {
namespace {

using Eigen::Vector3f;
using sim_detail::Surface;

constexpr int kLedsPerSide = 16;
constexpr int kLeds = kLedsPerSide * kLedsPerSide;
constexpr float kLedDropMm = 0.5F;  // LEDs sit below the ceiling, clear of its geometry
constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kSurfaceOffsetMm = 0.02F;
constexpr unsigned kBackWall = 0;
using LedVector = Eigen::Array<float, kLeds, 1>;

// One downward Lambertian source; irradiance is intensity * cos * cos / r^2.
float lambert_term(const Vector3f& led, const Vector3f& p, const Vector3f& n) {
  const Vector3f d = led - p;
  const float cos_surface = d.dot(n), cos_led = d.y();
  if (cos_surface <= 0 || cos_led <= 0) return 0;
  const float r2 = d.squaredNorm();
  return cos_surface * cos_led / (r2 * r2);
}

}  // namespace

std::array<Eigen::Vector3d, kMarkerCount> marker_positions_rsb_mm() {
  return {Eigen::Vector3d(100, 68, 0.2), Eigen::Vector3d(270, 68, 0.2),
          Eigen::Vector3d(100, 192, 0.2), Eigen::Vector3d(270, 192, 0.2)};
}

struct Scene::Impl {
  std::vector<Surface> surfaces;  // at the Embree geometry id
  LedVector led_x, led_z;
  float led_y = 0;
  float led_intensity = 0;  // of one LED in cd/m^2 mm^2, at drive 1
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  tbb::collaborative_once_flag baked;

  ~Impl() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  Vector3f led(int i) const { return {led_x[i], led_y, led_z[i]}; }

  void place_leds() {
    led_y = static_cast<float>(kBoxSizeMm.y()) - kLedDropMm;
    for (int i = 0; i < kLeds; ++i) {
      const float u = (static_cast<float>(i % kLedsPerSide) + 0.5F) / kLedsPerSide;
      const float v = (static_cast<float>(i / kLedsPerSide) + 0.5F) / kLedsPerSide;
      led_x[i] = u * static_cast<float>(kBoxSizeMm.x());
      led_z[i] = v * static_cast<float>(kBoxSizeMm.z());
    }
    float sum = 0;
    for (int i = 0; i < kLeds; ++i) sum += lambert_term(led(i), {185, 130, 1}, {0, 0, 1});
    led_intensity = static_cast<float>(kCardWhiteCdM2) * kPi / sum;
  }

  void build() {
    device = rtcNewDevice(nullptr);
    if (!device) throw InternalError("Embree gives no device");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < surfaces.size(); ++i) attach(surfaces[i], static_cast<unsigned>(i));
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) throw InternalError("Embree scene failed");
  }

  void attach(const Surface& s, unsigned id) {
    const bool quad = s.kind == Surface::Kind::kQuad;
    RTCGeometry geometry =
        rtcNewGeometry(device, quad ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_SPHERE_POINT);
    if (quad) {
      auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4));
      auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), 1));
      const Vector3f corners[4] = {s.origin, s.origin + s.edge_u, s.origin + s.edge_u + s.edge_v,
                                   s.origin + s.edge_v};
      for (int k = 0; k < 4; ++k) {
        std::copy_n(corners[k].data(), 3, vertex + 3 * k);
        index[k] = static_cast<unsigned>(k);
      }
    } else {
      auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 1));
      std::copy_n(s.origin.data(), 3, vertex);
      vertex[3] = s.radius;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  }

  // Irradiance / pi at a surface point, every LED with its shadow ray.
  float irradiance_over_pi(const Vector3f& p, const Vector3f& n) const {
    const Vector3f start = p + kSurfaceOffsetMm * n;
    float sum = 0;
    for (int first = 0; first < kLeds; first += kPacket) {
      alignas(32) int valid[kPacket];
      float term[kPacket];
      RTCRay8 ray;
      bool any = false;
      for (int k = 0; k < kPacket; ++k) {
        const Vector3f d = led(first + k) - start;
        term[k] = lambert_term(led(first + k), start, n);
        valid[k] = term[k] > 0 ? -1 : 0;
        any |= term[k] > 0;
        ray.org_x[k] = start.x(), ray.org_y[k] = start.y(), ray.org_z[k] = start.z();
        ray.dir_x[k] = d.x(), ray.dir_y[k] = d.y(), ray.dir_z[k] = d.z();
        ray.tnear[k] = 0, ray.tfar[k] = 1, ray.time[k] = 0;
        ray.mask[k] = ~0U, ray.id[k] = 0, ray.flags[k] = 0;
      }
      if (!any) continue;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcOccluded8(valid, scene, &context, &ray);
      for (int k = 0; k < kPacket; ++k) {
        if (valid[k] && ray.tfar[k] >= 0) sum += term[k];  // a blocked ray has tfar = -inf
      }
    }
    return led_intensity * sum / kPi;
  }

  void bake(Surface& s) const {
    s.baked_cd_m2.resize(static_cast<std::size_t>(s.nu) * s.nv);
    tbb::parallel_for(0, s.nv, [&](int j) {
      for (int i = 0; i < s.nu; ++i) {
        // Kept off the very edge, where another wall begins.
        const float u = std::clamp(static_cast<float>(i) / (s.nu - 1), 0.001F, 0.999F);
        const float v = std::clamp(static_cast<float>(j) / (s.nv - 1), 0.001F, 0.999F);
        const bool ball = s.kind == Surface::Kind::kSphere;
        const Vector3f p =
            ball ? s.point_at(static_cast<float>(i) / (s.nu - 1), v) : s.point_at(u, v);
        s.baked_cd_m2[static_cast<std::size_t>(j) * s.nu + i] =
            irradiance_over_pi(p, s.normal_at(p));
      }
    });
  }

  // Whoever needs it first may be in a parallel loop: those that wait for it help.
  void bake_once() {
    tbb::collaborative_call_once(baked, [&] {
      for (Surface& s : surfaces) bake(s);
    });
  }

  // Phong lobe of exponent 32 summed over the LEDs, in cd/m^2 at drive 1. Occlusion by other
  // objects is left out: no object of ours stands between a sphere and the ceiling.
  float phong(const Vector3f& p, const Vector3f& n, const Vector3f& to_eye) const {
    const Vector3f r = 2 * n.dot(to_eye) * n - to_eye;
    const float dy = led_y - p.y();
    float sum = 0;
    for (int row = 0; row < kLedsPerSide; ++row) {  // LEDs of one row share z
      const float dz = led_z[row * kLedsPerSide] - p.z();
      // The best cosine any LED of the row could reach; below this the lobe is under 1e-4.
      const float across = std::max(0.0F, r.y() * dy + r.z() * dz);
      if (r.x() * r.x() + across * across / (dy * dy + dz * dz) < 0.56F) continue;
      using Row = Eigen::Array<float, kLedsPerSide, 1>;
      const Row dx = led_x.segment<kLedsPerSide>(row * kLedsPerSide) - p.x();
      const Row inverse_r = (dx * dx + (dz * dz + dy * dy)).rsqrt();
      const float r_rest = r.z() * dz + r.y() * dy, n_rest = n.z() * dz + n.y() * dy;
      Row lobe = ((dx * r.x() + r_rest) * inverse_r).max(0.0F);
      for (int k = 0; k < 5; ++k) lobe *= lobe;
      const Row cos_surface = ((dx * n.x() + n_rest) * inverse_r).max(0.0F);
      sum += (lobe * cos_surface * inverse_r * inverse_r * inverse_r).sum();
    }
    return led_intensity * (32 + 2) / (2 * kPi) * sum * dy;
  }

  Vector3f shade(const Surface& s, const Vector3f& p, const Vector3f& direction,
                 const BoxLight& light) const {
    const Vector3f n = s.normal_at(p);
    if (n.dot(direction) >= 0) return Vector3f::Zero();  // outside of a wall, back of a card
    const auto drive = static_cast<float>(light.led_drive);
    if (drive <= 0) return Vector3f::Zero();
    Vector3f rgb = s.albedo_at(p) * s.baked_at(p);
    if (s.specular > 0) {
      rgb += Vector3f::Constant(s.specular * phong(p, n, -direction.normalized()));
    }
    return drive * rgb;
  }

  // Markers float 0.2 mm before the back wall, so only rays that reach the wall can meet one.
  bool hits_lit_marker(const Ray& ray, unsigned mask) const {
    static const auto markers = marker_positions_rsb_mm();
    const float t = (static_cast<float>(markers[0].z()) - ray.origin.z()) / ray.direction.z();
    const Vector3f p = ray.origin + t * ray.direction;
    for (unsigned i = 0; i < kMarkerCount; ++i) {
      if (!(mask >> i & 1U)) continue;
      const float dx = p.x() - static_cast<float>(markers[i].x());
      const float dy = p.y() - static_cast<float>(markers[i].y());
      if (dx * dx + dy * dy <= static_cast<float>(kMarkerRadiusMm * kMarkerRadiusMm)) return true;
    }
    return false;
  }
};

Scene::Scene(const std::string& name) : impl_(std::make_unique<Impl>()) {
  impl_->surfaces = sim_detail::make_surfaces(name);
  impl_->place_leds();
  impl_->build();
}

Scene::~Scene() = default;

void Scene::radiance(const Ray* rays, int count, const BoxLight& light, Vector3f* rgb) const {
  if (light.led_drive > 0) impl_->bake_once();
  alignas(32) int valid[kPacket];
  RTCRayHit8 query;
  for (int k = 0; k < kPacket; ++k) {
    const Ray& r = rays[k < count ? k : 0];
    valid[k] = k < count ? -1 : 0;
    query.ray.org_x[k] = r.origin.x(), query.ray.org_y[k] = r.origin.y();
    query.ray.org_z[k] = r.origin.z();
    query.ray.dir_x[k] = r.direction.x(), query.ray.dir_y[k] = r.direction.y();
    query.ray.dir_z[k] = r.direction.z();
    query.ray.tnear[k] = 0, query.ray.tfar[k] = std::numeric_limits<float>::infinity();
    query.ray.time[k] = 0, query.ray.mask[k] = ~0U, query.ray.id[k] = 0, query.ray.flags[k] = 0;
    query.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, impl_->scene, &context, &query);
  for (int k = 0; k < count; ++k) {
    const unsigned id = query.hit.geomID[k];
    rgb[k].setZero();
    if (id == RTC_INVALID_GEOMETRY_ID) continue;
    if (id == kBackWall && light.marker_mask &&
        impl_->hits_lit_marker(rays[k], light.marker_mask)) {
      rgb[k].setConstant(static_cast<float>(kMarkerCdM2));
      continue;
    }
    const Vector3f p = rays[k].origin + query.ray.tfar[k] * rays[k].direction;
    rgb[k] = impl_->shade(impl_->surfaces[id], p, rays[k].direction, light);
  }
}

Vector3f Scene::radiance(const Ray& ray, const BoxLight& light) const {
  Vector3f rgb;
  radiance(&ray, 1, light, &rgb);
  return rgb;
}

}  // namespace wheatstone
