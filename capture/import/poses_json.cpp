#include "capture/import/poses_json.h"

#include <Eigen/LU>

#include "core/error.h"
#include "core/json.h"

namespace wheatstone {
namespace {

using nlohmann::json;

double optional_number(const json& object, const char* key, const std::filesystem::path& file) {
  return object.contains(key) ? json_get<double>(object, key, file) : 0;
}

ImportedView view_from(const json& j, const std::filesystem::path& file) {
  ImportedView v;
  v.name = json_get<std::string>(j, "name", file);
  const std::filesystem::path picture = json_get<std::string>(j, "file", file);
  v.path = file.parent_path() / picture;  // an absolute `picture` stays as it is
  std::error_code ignored;
  if (picture.empty() || !std::filesystem::is_regular_file(v.path, ignored)) v.path.clear();

  const json k = json_get<json>(j, "K", file);
  const auto size = json_get<std::vector<int>>(j, "size", file);
  if (size.size() != 2 || size[0] < 1 || size[1] < 1 || size[0] > 65536 || size[1] > 65536)
    throw_bad_key(file, "size", "of view " + v.name + " is not [width, height] in 1..65536 px");
  v.intrinsics = {json_get<double>(k, "fx_px", file),
                  json_get<double>(k, "fy_px", file),
                  optional_number(k, "skew_px", file),
                  json_get<double>(k, "cx_px", file),
                  json_get<double>(k, "cy_px", file),
                  size[0],
                  size[1]};
  if (!(v.intrinsics.fx_px > 0) || !(v.intrinsics.fy_px > 0))
    throw_bad_key(file, "K", "of view " + v.name + " has a focal length that is not above 0");
  if (j.contains("distortion")) {
    const json d = json_get<json>(j, "distortion", file);
    v.distortion = {optional_number(d, "k1", file), optional_number(d, "k2", file),
                    optional_number(d, "p1", file), optional_number(d, "p2", file),
                    optional_number(d, "k3", file), optional_number(d, "k4", file),
                    optional_number(d, "k5", file), optional_number(d, "k6", file)};
    v.distortion.fisheye = d.contains("fisheye") && json_get<bool>(d, "fisheye", file);
  }
  v.T_camera_world.R = matrix_from_json(json_get<json>(j, "R", file), 3, 3, file, "R");
  v.T_camera_world.t_mm = vector3_from_json(json_get<json>(j, "t_mm", file), file, "t_mm");
  const Eigen::Matrix3d& R = v.T_camera_world.R;
  if (!((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6) ||
      !(R.determinant() > 0))
    throw_bad_key(file, "R", "of view " + v.name + " is not a rotation");
  return v;
}

}  // namespace

std::vector<ImportedView> read_poses_json(const std::filesystem::path& path) {
  const json root = read_json(path, kPosesSchema);
  const std::string remedy =
      std::string("convert the poses if need be and add \"convention\": \"") + kPoseConvention +
      "\"";
  if (!root.contains("convention"))
    throw FileError(path, "does not say the convention of its poses", remedy);
  if (root["convention"] != kPoseConvention)
    throw FileError(path, "states a convention that is not read", remedy);
  const json list = json_get<json>(root, "views", path);
  if (!list.is_array()) throw_bad_key(path, "views", "is not a list");
  std::vector<ImportedView> views;
  for (const json& j : list) views.push_back(view_from(j, path));
  return views;
}

void write_poses_json(const std::filesystem::path& path, std::span<const ImportedView> views) {
  json list = json::array();
  for (const ImportedView& v : views) {
    const auto inside = v.path.lexically_relative(path.parent_path());
    const bool is_inside = !inside.empty() && *inside.begin() != "..";
    const Intrinsics& k = v.intrinsics;
    const Distortion& d = v.distortion;
    json j = {{"name", v.name},
              {"file", (is_inside ? inside : v.path).generic_string()},
              {"K",
               {{"fx_px", k.fx_px},
                {"fy_px", k.fy_px},
                {"skew_px", k.skew_px},
                {"cx_px", k.cx_px},
                {"cy_px", k.cy_px}}},
              {"size", {k.width_px, k.height_px}},
              {"R", to_json(Eigen::MatrixXd(v.T_camera_world.R))},
              {"t_mm", to_json(v.T_camera_world.t_mm)}};
    if (!d.is_zero())
      j["distortion"] = {{"k1", d.k1}, {"k2", d.k2}, {"p1", d.p1}, {"p2", d.p2}, {"k3", d.k3}};
    if (!d.has_five_coefficients())
      j["distortion"].update({{"k4", d.k4}, {"k5", d.k5}, {"k6", d.k6}, {"fisheye", d.fisheye}});
    list.push_back(std::move(j));
  }
  write_json(path, kPosesSchema, {{"convention", kPoseConvention}, {"views", list}});
}

}  // namespace wheatstone
