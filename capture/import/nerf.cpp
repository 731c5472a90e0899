#include "capture/import/nerf.h"

#include <cmath>
#include <map>
#include <numbers>

#include "core/error.h"
#include "core/files.h"
#include "core/json.h"

namespace wheatstone {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double kPixelCentre = 0.5;  // the format's coordinate of the first pixel's centre

/// A number of the frame, or of the whole file, or `fallback` when neither has it.
double number(const json& frame, const json& root, const char* key, double fallback,
              const fs::path& file) {
  for (const json* object : {&frame, &root})
    if (object->contains(key)) return json_get<double>(*object, key, file);
  return fallback;
}

fs::path picture_of(const fs::path& file, const std::string& stated) {
  const fs::path base = file.parent_path() / stated;
  std::error_code ignored;
  for (const char* ending : {"", ".png", ".jpg", ".jpeg"})
    if (fs::path path = base.string() + ending; fs::is_regular_file(path, ignored)) return path;
  return {};
}

/// A picture's place as seen from the folder of the file that names it.
std::string place_from(const fs::path& file, const fs::path& picture) {
  std::error_code error;
  const fs::path place = fs::relative(picture, fs::absolute(file).parent_path(), error);
  if (error || place.empty())
    throw FileError(file, "cannot name " + picture.string() + " relative to itself",
                    "export into a folder on the same file system");
  return place.generic_string();
}

ImportedView view_from(const json& frame, const json& root, const fs::path& file,
                       double mm_per_unit, PoseConvention convention) {
  ImportedView v;
  const std::string stated = json_get<std::string>(frame, "file_path", file);
  v.name = fs::path(stated).filename().string();
  v.path = picture_of(file, stated);
  double w = number(frame, root, "w", 0, file), h = number(frame, root, "h", 0, file);
  if (w == 0 && h == 0 && !v.path.empty()) {
    const cv::Size size = picture_size(v.path);
    w = size.width, h = size.height;
  }
  if (!(w >= 1 && h >= 1 && w <= 65536 && h <= 65536))
    throw_bad_key(file, "w, h", "of " + stated + " are not in 1..65536, and no picture says them");
  const double angle = number(frame, root, "camera_angle_x", 0, file);
  const double of_angle =
      angle > 0 && angle < std::numbers::pi ? 0.5 * w / std::tan(0.5 * angle) : 0;
  const double fx = number(frame, root, "fl_x", of_angle, file);
  const double fy = number(frame, root, "fl_y", fx, file);
  if (!(fx > 0) || !(fy > 0) || !std::isfinite(fx) || !std::isfinite(fy))
    throw_bad_key(file, "fl_x",
                  "of " + stated +
                      " is no focal length above 0, nor is there a "
                      "camera_angle_x between 0 and pi");
  v.intrinsics = {fx,
                  fy,
                  0,
                  number(frame, root, "cx", w / 2, file) - kPixelCentre,
                  number(frame, root, "cy", h / 2, file) - kPixelCentre,
                  static_cast<int>(w),
                  static_cast<int>(h)};
  Distortion& d = v.distortion;
  d.k1 = number(frame, root, "k1", 0, file);
  d.k2 = number(frame, root, "k2", 0, file);
  d.p1 = number(frame, root, "p1", 0, file);
  d.p2 = number(frame, root, "p2", 0, file);
  const json& with_model = frame.contains("camera_model") ? frame : root;
  const std::string model = with_model.contains("camera_model")
                                ? json_get<std::string>(with_model, "camera_model", file)
                                : "OPENCV";
  d.fisheye = model == "OPENCV_FISHEYE";
  if (!d.fisheye && model != "OPENCV" && model != "PINHOLE")
    throw_bad_key(file, "camera_model",
                  "is " + model + "; OPENCV, PINHOLE and OPENCV_FISHEYE are read");
  const double k3 = number(frame, root, "k3", 0, file), k4 = number(frame, root, "k4", 0, file);
  if (d.fisheye)
    d.k3 = k3, d.k4 = k4, d.p1 = d.p2 = 0;
  else if (k4 == 0)
    d.k3 = k3;
  else
    throw_bad_key(file, "k4", "belongs to OPENCV_FISHEYE alone");

  const Eigen::Matrix4d m = matrix_from_json(json_get<json>(frame, "transform_matrix", file), 4, 4,
                                             file, "transform_matrix");
  const Eigen::Matrix3d R = m.topLeftCorner<3, 3>();
  if (!m.allFinite() || !((R * R.transpose()).isIdentity(1e-4)) || !(R.determinant() > 0))
    throw_bad_key(file, "transform_matrix", "of " + stated + " holds no rotation");
  if (!m.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1)))
    throw_bad_key(file, "transform_matrix", "of " + stated + " does not end in 0 0 0 1");
  // Printed rotations are rounded; ours are exact.
  Eigen::Matrix<double, 3, 4> rigid;
  rigid << Eigen::Quaterniond(R).normalized().toRotationMatrix(), mm_per_unit * m.col(3).head<3>();
  v.T_camera_world = from_stated(rigid, convention);
  return v;
}

std::vector<KnownPoint> points_from(const json& root, const fs::path& file, std::size_t views,
                                    double mm_per_unit) {
  std::vector<KnownPoint> points;
  if (!root.contains("check_points")) return points;
  const json list = json_get<json>(root, "check_points", file);
  if (!list.is_array()) throw_bad_key(file, "check_points", "is not a list");
  for (const json& p : list) {
    const Eigen::Vector3d p_world =
        mm_per_unit * vector3_from_json(json_get<json>(p, "p_world", file), file, "p_world");
    const json seen_list = json_get<json>(p, "seen", file);
    if (!seen_list.is_array()) throw_bad_key(file, "seen", "is not a list");
    for (const json& seen : seen_list) {
      const auto frame = json_get<std::uint64_t>(seen, "frame", file);
      if (frame >= views) throw_bad_key(file, "frame", "of a check point is not in the file");
      points.push_back({static_cast<std::size_t>(frame), p_world,
                        vector2_from_json(json_get<json>(seen, "px", file), file, "px") -
                            Eigen::Vector2d::Constant(kPixelCentre)});
    }
  }
  return points;
}

PoseConvention convention_of(const json& root, const fs::path& file,
                             std::optional<PoseConvention> wanted) {
  if (!root.contains("convention")) return wanted.value_or(kNerfConvention);
  PoseConvention stated;
  try {
    stated = pose_convention_from_string(json_get<std::string>(root, "convention", file));
  } catch (const ArgumentError& e) {
    throw FileError(file, e.what(), "");
  }
  if (wanted && !(*wanted == stated))
    throw FileError(file,
                    "says that its poses are " + to_string(stated) + ", not " + to_string(*wanted),
                    "leave --convention out, or correct the file");
  return stated;
}

}  // namespace

NerfModel read_nerf(const fs::path& file, double mm_per_unit,
                    std::optional<PoseConvention> wanted) {
  if (!(mm_per_unit > 0) || !std::isfinite(mm_per_unit))
    throw ArgumentError("the scale of poses must be above 0", "give mm per unit");
  json root;
  try {
    root = json::parse(read_text(file));
  } catch (const json::exception& e) {
    throw FileError(file, std::string("is not valid JSON: ") + e.what(), "write it again");
  }
  const json frames = json_get<json>(root, "frames", file);
  if (!frames.is_array() || frames.empty()) throw_bad_key(file, "frames", "is not a list of views");
  NerfModel model;
  model.convention = convention_of(root, file, wanted);
  for (const json& frame : frames) {
    if (!frame.is_object()) throw_bad_key(file, "frames", "holds something that is no view");
    model.views.push_back(view_from(frame, root, file, mm_per_unit, model.convention));
  }
  model.known_points = points_from(root, file, model.views.size(), mm_per_unit);
  return model;
}

void write_nerf(const fs::path& file, std::span<const ImportedView> views,
                std::span<const KnownPoint> points) {
  json frames = json::array();
  for (const ImportedView& v : views) {
    const Intrinsics& k = v.intrinsics;
    const Distortion& d = v.distortion;
    if (k.skew_px != 0 || (!d.fisheye && !d.has_five_coefficients()))
      throw ArgumentError(v.name + ": transforms.json cannot hold its skew or its k4 to k6",
                          "export the undistorted views (views.json)");
    json frame = {{"file_path", v.path.empty() ? v.name : place_from(file, v.path)},
                  {"fl_x", k.fx_px},
                  {"fl_y", k.fy_px},
                  {"cx", k.cx_px + kPixelCentre},
                  {"cy", k.cy_px + kPixelCentre},
                  {"w", k.width_px},
                  {"h", k.height_px},
                  {"camera_model", d.fisheye ? "OPENCV_FISHEYE" : "OPENCV"}};
    if (d.fisheye)
      frame.update({{"k1", d.k1}, {"k2", d.k2}, {"k3", d.k3}, {"k4", d.k4}});
    else
      frame.update({{"k1", d.k1}, {"k2", d.k2}, {"p1", d.p1}, {"p2", d.p2}, {"k3", d.k3}});
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topRows<3>() = to_stated(v.T_camera_world, kNerfConvention);
    frame["transform_matrix"] = to_json(Eigen::MatrixXd(m));
    frames.push_back(std::move(frame));
  }
  json list = json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const KnownPoint& p = points[i];
    if (i == 0 || p.p_world_mm != points[i - 1].p_world_mm)
      list.push_back({{"p_world", to_json(p.p_world_mm)}, {"seen", json::array()}});
    list.back()["seen"].push_back(
        {{"frame", p.view},
         {"px", to_json(Eigen::Vector2d(p.px + Eigen::Vector2d::Constant(kPixelCentre)))}});
  }
  const json root = {
      {"convention", to_string(kNerfConvention)}, {"frames", frames}, {"check_points", list}};
  write_text_atomically(file, root.dump(2) + "\n");
}

}  // namespace wheatstone
