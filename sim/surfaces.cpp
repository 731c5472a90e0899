#include "sim/surfaces.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "core/error.h"
#include "sim/scene.h"

namespace wheatstone {

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = {"card", "sphere", "objects"};
  return names;
}

namespace sim_detail {
namespace {

using Eigen::Vector3f;
constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kWallAlbedo = 0.03F;

// Two waves shared by all colours carry the detail, one broad wave per colour the patches.
struct Wave {
  Vector3f k_rad_mm;
  float phase, weight;
};
Wave wave(float period_mm, float degrees, float tilt_z, float phase, float weight) {
  const float a = degrees * kPi / 180;
  const Vector3f direction = Vector3f(std::cos(a), std::sin(a), tilt_z).normalized();
  return {2 * kPi / period_mm * direction, phase, weight};
}
const std::array<Wave, 4> kDetail = {
    wave(6.1F, 25, 0.2F, 0.3F, 0.16F), wave(7.7F, 118, -0.3F, 1.9F, 0.18F),
    wave(12.9F, 70, 0.1F, 4.1F, 0.20F), wave(19.3F, -12, 0.4F, 2.6F, 0.22F)};
const std::array<Wave, 3> kPatch = {wave(41, 10, 0.3F, 0, 0.5F), wave(53, 75, -0.2F, 2, 0.5F),
                                    wave(37, 140, 0.1F, 4, 0.5F)};

// Five faces of an axis-aligned box; the floor side is never seen.
void add_box(std::vector<Surface>& out, const Vector3f& low, const Vector3f& high) {
  const Vector3f d = high - low;
  const Vector3f x(d.x(), 0, 0), y(0, d.y(), 0), z(0, 0, d.z());
  out.push_back(Surface::quad({low.x(), low.y(), high.z()}, x, y, true, 2));  // front
  out.push_back(Surface::quad(low, y, x, true, 2));                           // back
  out.push_back(Surface::quad(low, z, y, true, 2));                           // left
  out.push_back(Surface::quad({high.x(), low.y(), low.z()}, y, z, true, 2));  // right
  out.push_back(Surface::quad({low.x(), high.y(), low.z()}, z, x, true, 2));  // top
}

}  // namespace

Surface Surface::quad(const Vector3f& origin, const Vector3f& edge_u, const Vector3f& edge_v,
                      bool textured, float node_mm) {
  Surface s;
  s.origin = origin;
  s.edge_u = edge_u;
  s.edge_v = edge_v;
  s.quad_normal = edge_u.cross(edge_v).normalized();
  s.textured = textured;
  s.nu = std::max(2, static_cast<int>(std::ceil(edge_u.norm() / node_mm)) + 1);
  s.nv = std::max(2, static_cast<int>(std::ceil(edge_v.norm() / node_mm)) + 1);
  return s;
}

Surface Surface::sphere(const Vector3f& centre, float radius, float specular) {
  Surface s;
  s.kind = Kind::kSphere;
  s.origin = centre;
  s.radius = radius;
  s.specular = specular;
  s.textured = true;
  s.nu = 129;  // longitude, first and last node coincide
  s.nv = 65;   // from the lower to the upper pole
  return s;
}

Eigen::Vector2f Surface::uv_at(const Vector3f& p) const {
  const Vector3f d = p - origin;
  if (kind == Kind::kQuad) {
    return {d.dot(edge_u) / edge_u.squaredNorm(), d.dot(edge_v) / edge_v.squaredNorm()};
  }
  const float longitude = std::atan2(d.x(), d.z());
  const float polar = std::acos(std::clamp(-d.y() / radius, -1.0F, 1.0F));
  return {longitude / (2 * kPi) + 0.5F, polar / kPi};
}

Vector3f Surface::point_at(float u, float v) const {
  if (kind == Kind::kQuad) return origin + u * edge_u + v * edge_v;
  const float longitude = (u - 0.5F) * 2 * kPi, polar = v * kPi;
  const Vector3f n(std::sin(polar) * std::sin(longitude), -std::cos(polar),
                   std::sin(polar) * std::cos(longitude));
  return origin + radius * n;
}

float Surface::baked_at(const Vector3f& p) const {
  const Eigen::Vector2f uv = uv_at(p);
  const float x = std::clamp(uv.x(), 0.0F, 1.0F) * static_cast<float>(nu - 1);
  const float y = std::clamp(uv.y(), 0.0F, 1.0F) * static_cast<float>(nv - 1);
  const int i = std::min(static_cast<int>(x), nu - 2), j = std::min(static_cast<int>(y), nv - 2);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const float* row = baked_cd_m2.data() + static_cast<std::size_t>(j) * nu + i;
  return (1 - fy) * ((1 - fx) * row[0] + fx * row[1]) +
         fy * ((1 - fx) * row[nu] + fx * row[nu + 1]);
}

Vector3f Surface::albedo_at(const Vector3f& p) const {
  if (!textured) return Vector3f::Constant(kWallAlbedo);
  std::array<float, 4> detail;
  for (std::size_t i = 0; i < 4; ++i) {
    detail[i] = kDetail[i].weight * std::sin(kDetail[i].k_rad_mm.dot(p) + kDetail[i].phase);
  }
  Vector3f rgb;
  for (std::size_t c = 0; c < 3; ++c) {
    // Other signs per colour give the detail itself colour, not only luminance.
    float s = kPatch[c].weight * std::sin(kPatch[c].k_rad_mm.dot(p) + kPatch[c].phase) + detail[0];
    s += c == 0   ? detail[1] + detail[2] - detail[3]
         : c == 1 ? detail[1] - detail[2] + detail[3]
                  : -detail[1] + detail[2] + detail[3];
    s *= 3;
    rgb[static_cast<int>(c)] = 0.475F + 0.375F * s / std::sqrt(1 + s * s);
  }
  if (rim_mm > 0) {
    const Eigen::Vector2f uv = uv_at(p);
    const float to_edge_mm = std::min(std::min(uv.x(), 1 - uv.x()) * edge_u.norm(),
                                      std::min(uv.y(), 1 - uv.y()) * edge_v.norm());
    const float t = std::clamp(to_edge_mm / rim_mm, 0.0F, 1.0F);
    const float shown = t * t * (3 - 2 * t);
    rgb = shown * rgb + (1 - shown) * Vector3f::Constant(kWallAlbedo);
  }
  return rgb;
}

std::vector<Surface> make_surfaces(const std::string& scene_name) {
  const Vector3f box = kBoxSizeMm.cast<float>();
  const Vector3f x(box.x(), 0, 0), y(0, box.y(), 0), z(0, 0, box.z());
  constexpr float kWallNodeMm = 5;
  std::vector<Surface> out;
  out.push_back(Surface::quad(Vector3f::Zero(), x, y, false, kWallNodeMm));  // back wall: index 0
  out.push_back(Surface::quad(Vector3f::Zero(), z, x, false, kWallNodeMm));  // floor
  out.push_back(Surface::quad(y, x, z, false, kWallNodeMm));                 // ceiling
  out.push_back(Surface::quad(Vector3f::Zero(), y, z, false, kWallNodeMm));  // left
  out.push_back(Surface::quad(x, z, y, false, kWallNodeMm));                 // right

  if (scene_name == "card") {
    out.push_back(Surface::quad({115, 80, 1}, {140, 0, 0}, {0, 100, 0}, true, 2));
    out.back().rim_mm = 8;  // so that the card has no detail finer than its texture
  } else if (scene_name == "sphere") {
    out.push_back(Surface::sphere({185, 115, 150}, 35, 0.15F));
  } else if (scene_name == "objects") {
    // Seen from either eye the front box hides part of the sphere, and the sphere of the card.
    out.push_back(Surface::quad({175, 90, 60}, {60, 0, 0}, {0, 80, 0}, true, 2));
    out.push_back(Surface::sphere({165, 122, 170}, 28, 0.15F));
    add_box(out, {177, 110, 260}, {207, 146, 280});
  } else {
    std::string known;
    for (const std::string& name : scene_names()) known += (known.empty() ? "" : ", ") + name;
    throw ArgumentError("unknown scene '" + scene_name + "'", "use one of: " + known);
  }
  return out;
}

}  // namespace sim_detail
}  // namespace wheatstone
