#pragma once
// The surfaces a scene is made of and their textures.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

namespace wheatstone::sim_detail {

/// A parallelogram seen from the side of its normal, or a sphere seen from outside.
struct Surface {
  enum class Kind { kQuad, kSphere };
  Kind kind = Kind::kQuad;
  Eigen::Vector3f origin;          // quad: corner at (u, v) = (0, 0); sphere: centre
  Eigen::Vector3f edge_u, edge_v;  // quad only
  Eigen::Vector3f quad_normal;
  float radius = 0;
  bool textured = false;  // else a black wall
  float specular = 0;     // weight of the Phong lobe
  float rim_mm = 0;       // quad: the texture fades to black over this distance from the edge

  // Irradiance / pi in cd/m^2 at drive 1, on nodes u = i/(nu-1), v = j/(nv-1); [j * nu + i].
  int nu = 0, nv = 0;
  std::vector<float> baked_cd_m2;

  static Surface quad(const Eigen::Vector3f& origin, const Eigen::Vector3f& edge_u,
                      const Eigen::Vector3f& edge_v, bool textured, float node_mm);
  static Surface sphere(const Eigen::Vector3f& centre, float radius, float specular);

  Eigen::Vector3f normal_at(const Eigen::Vector3f& p) const {
    return kind == Kind::kQuad ? quad_normal : ((p - origin) / radius).eval();
  }
  Eigen::Vector2f uv_at(const Eigen::Vector3f& p) const;
  Eigen::Vector3f point_at(float u, float v) const;
  float baked_at(const Eigen::Vector3f& p) const;
  Eigen::Vector3f albedo_at(const Eigen::Vector3f& p) const;
};

/// Walls and contents of a named scene. Throws ArgumentError for an unknown name.
std::vector<Surface> make_surfaces(const std::string& scene_name);

}  // namespace wheatstone::sim_detail
