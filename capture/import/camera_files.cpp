#include "capture/import/camera_files.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <sstream>

#include "capture/import/colmap_lens.h"
#include "capture/import/colmap_records.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

using std::filesystem::path;

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

[[noreturn]] void fail(const path& file, const std::string& problem) {
  throw FileError(file, problem, "export it again from the program that wrote it");
}

void check(const CameraFile& c, const path& file) {
  const Intrinsics& k = c.intrinsics;
  bool finite = k.K().allFinite();
  for (const double v : c.distortion.coefficients()) finite = finite && std::isfinite(v);
  if (!finite) fail(file, "holds a number that is not finite");
  if (!(k.fx_px > 0) || !(k.fy_px > 0)) fail(file, "has a focal length that is not above 0");
  if (k.width_px < 1 || k.height_px < 1 || k.width_px > 65536 || k.height_px > 65536)
    fail(file, "has a picture size outside 1..65536 px");
}

std::vector<double> numbers(const cv::FileNode& node, const path& file, const std::string& key) {
  if (!node.isSeq()) fail(file, "key \"" + key + "\" is not a list of numbers");
  std::vector<double> values;
  for (const cv::FileNode& v : node) {
    if (!v.isInt() && !v.isReal()) fail(file, "key \"" + key + "\" is not a list of numbers");
    values.push_back(v.real());
  }
  return values;
}

cv::Mat1d matrix(const cv::FileNode& node, const path& file, const std::string& key) {
  const auto values = numbers(node["data"], file, key + ".data");
  const int rows = node["rows"].isInt() ? static_cast<int>(node["rows"]) : 0;
  const int cols = node["cols"].isInt() ? static_cast<int>(node["cols"]) : 0;
  if (rows < 1 || cols < 1 || rows > 100 || cols > 100 ||
      values.size() != static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols))
    fail(file, "key \"" + key + "\" is not a matrix with as many numbers as it says");
  return cv::Mat1d(values, true).reshape(1, rows);
}

int integer(const cv::FileNode& node, const path& file, const std::string& key) {
  if (!node.isInt()) fail(file, "key \"" + key + "\" is not a whole number");
  return static_cast<int>(node);
}

CameraFile opencv_camera(const cv::FileStorage& yaml, const path& file) {
  CameraFile c;
  const cv::Mat1d K = matrix(yaml["camera_matrix"], file, "camera_matrix");
  if (K.size() != cv::Size(3, 3) || K(1, 0) != 0 || K(2, 0) != 0 || K(2, 1) != 0 || K(2, 2) != 1)
    fail(file, "key \"camera_matrix\" is not an upper triangular 3x3 matrix with a 1 at its end");
  c.intrinsics = {K(0, 0),
                  K(1, 1),
                  K(0, 1),
                  K(0, 2),
                  K(1, 2),
                  integer(yaml["image_width"], file, "image_width"),
                  integer(yaml["image_height"], file, "image_height")};
  const cv::FileNode model = yaml["fisheye_model"];
  const bool fisheye = !model.empty() && integer(model, file, "fisheye_model") != 0;
  const cv::Mat1d stored = matrix(yaml["distortion_coefficients"], file, "distortion_coefficients");
  const std::vector<double> d(stored.begin(), stored.end());
  if (fisheye) {
    if (d.size() != 4) fail(file, "has a fisheye model without 4 coefficients");
    c.distortion = {d[0], d[1], 0, 0, d[2], d[3], 0, 0, true};
  } else {
    if (d.size() != 4 && d.size() != 5 && d.size() != 8)
      fail(file,
           "has " + std::to_string(d.size()) + " distortion coefficients; 4, 5 or 8 are read");
    const auto at = [&](std::size_t i) { return i < d.size() ? d[i] : 0; };
    c.distortion = {d[0], d[1], d[2], d[3], at(4), at(5), at(6), at(7)};
  }
  return c;
}

std::string text(const cv::FileNode& node, const path& file, const std::string& key) {
  if (!node.isString()) fail(file, "key \"" + key + "\" is not a text");
  return node.string();
}

CameraFile kalibr_camera(const cv::FileNode& camera, const path& file, const std::string& name) {
  const auto list = [&](const char* key, std::size_t size) {
    const auto values = numbers(camera[key], file, name + "." + key);
    if (values.size() != size)
      fail(file, fmt::format("key \"{}.{}\" does not have {} numbers", name, key, size));
    return values;
  };
  const std::string model = text(camera["camera_model"], file, name + ".camera_model");
  if (model != "pinhole")
    fail(file, name + " has the camera model " + model + "; only pinhole is read");
  CameraFile c;
  const auto k = list("intrinsics", 4), size = list("resolution", 2);
  c.intrinsics = {k[0], k[1], 0, k[2], k[3]};
  for (const double s : size)
    if (!(s >= 1 && s <= 65536)) fail(file, name + " has a resolution outside 1..65536 px");
  c.intrinsics.width_px = static_cast<int>(size[0]);
  c.intrinsics.height_px = static_cast<int>(size[1]);
  const std::string lens = text(camera["distortion_model"], file, name + ".distortion_model");
  if (lens == "radtan") {
    const auto d = list("distortion_coeffs", 4);
    c.distortion = {d[0], d[1], d[2], d[3]};
  } else if (lens == "equidistant") {
    const auto d = list("distortion_coeffs", 4);
    c.distortion = {d[0], d[1], 0, 0, d[2], d[3], 0, 0, true};
  } else if (lens != "none") {
    fail(file, name + " has the distortion model " + lens + "; radtan, equidistant, none are read");
  }
  return c;
}

/// Kalibr's file as OpenCV's parser wants it: with a header, and lists below a key indented more
/// than the key.
std::string as_opencv_yaml(const std::string& kalibr) {
  std::string out = "%YAML:1.0\n---\n";
  std::istringstream lines(kalibr);
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find_first_not_of(' ');
    if (first != std::string::npos && line.compare(first, 2, "- ") == 0) out += "  ";
    out += line + "\n";
  }
  return out;
}

std::vector<CameraFile> read_yaml(const path& file, const std::string& contents) {
  const std::string yaml = contents.starts_with("%YAML") ? contents : as_opencv_yaml(contents);
  std::vector<CameraFile> cameras;
  try {
    const cv::FileStorage storage(
        yaml, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
    if (!storage["camera_matrix"].empty()) {
      cameras.push_back(opencv_camera(storage, file));
    } else {
      for (int i = 0; !storage["cam" + std::to_string(i)].empty(); ++i) {
        const std::string name = "cam" + std::to_string(i);
        cameras.push_back(kalibr_camera(storage[name], file, name));
      }
    }
  } catch (const cv::Exception& e) {
    fail(file, "is not YAML that can be read (" + e.err + ")");
  }
  if (cameras.empty())
    throw FileError(file, "has neither \"camera_matrix\" (OpenCV) nor \"cam0\" (Kalibr)",
                    "give a camera file of OpenCV, COLMAP or Kalibr");
  return cameras;
}

// Shortest text that reads back as the same number, with a point so that YAML knows it as one.
std::string exact(double v) {
  const std::string s = fmt::format("{}", v);
  return s.find_first_of(".en") == std::string::npos ? s + ".0" : s;
}

std::string joined(const std::vector<double>& values) {
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : ", ") + exact(v);
  return out;
}

std::vector<double> opencv_coefficients(const Distortion& d) {
  if (d.fisheye) return {d.k1, d.k2, d.k3, d.k4};
  if (d.has_five_coefficients()) return {d.k1, d.k2, d.p1, d.p2, d.k3};
  return {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
}

std::string opencv_text(const CameraFile& c) {
  const Intrinsics& k = c.intrinsics;
  const auto d = opencv_coefficients(c.distortion);
  return fmt::format(
      "%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\nfisheye_model: {}\n"
      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {} ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: {}\n   cols: 1\n   dt: d\n"
      "   data: [ {} ]\n",
      k.width_px, k.height_px, c.distortion.fisheye ? 1 : 0,
      joined({k.fx_px, k.skew_px, k.cx_px, 0, k.fy_px, k.cy_px, 0, 0, 1}), d.size(), joined(d));
}

std::string kalibr_text(const std::vector<CameraFile>& cameras,
                        const std::optional<RigidTransform>& T_second_first) {
  std::string out;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Intrinsics& k = cameras[i].intrinsics;
    const Distortion& d = cameras[i].distortion;
    out += fmt::format("cam{}:\n", i);
    if (i == 1 && T_second_first) {
      out += "  T_cn_cnm1:\n";
      const Eigen::Matrix3d& R = T_second_first->R;
      for (int r = 0; r < 3; ++r)
        out += fmt::format("  - [{}]\n",
                           joined({R(r, 0), R(r, 1), R(r, 2), T_second_first->t_mm[r] / 1000}));
      out += "  - [0.0, 0.0, 0.0, 1.0]\n";
    }
    out += fmt::format(
        "  camera_model: pinhole\n  intrinsics: [{}]\n  distortion_model: {}\n"
        "  distortion_coeffs: [{}]\n  resolution: [{}, {}]\n",
        joined({k.fx_px, k.fy_px, k.cx_px, k.cy_px}), d.fisheye ? "equidistant" : "radtan",
        d.fisheye ? joined({d.k1, d.k2, d.k3, d.k4}) : joined({d.k1, d.k2, d.p1, d.p2}), k.width_px,
        k.height_px);
  }
  return out;
}

}  // namespace

std::string to_string(CameraFormat f) {
  return f == CameraFormat::kOpenCv ? "opencv" : f == CameraFormat::kColmap ? "colmap" : "kalibr";
}

CameraFormat camera_format_from_string(const std::string& name) {
  for (const auto f : {CameraFormat::kOpenCv, CameraFormat::kColmap, CameraFormat::kKalibr})
    if (name == to_string(f)) return f;
  throw ArgumentError("'" + name + "' is no camera file format", "use opencv, colmap or kalibr");
}

std::vector<CameraFile> read_camera_file(const path& file) {
  const std::string contents = read_text(file, kMaxBytes);
  if (file.extension() == ".json" || contents.starts_with("{"))
    throw FileError(file, "is JSON, which is not read as a camera file",
                    "give an OpenCV or Kalibr .yaml or a COLMAP cameras.txt; calibrate camera "
                    "writes them beside its calibration.json");
  std::vector<CameraFile> cameras;
  if (file.extension() == ".txt") {
    const ColmapSource source{file.parent_path(), false, contents, {}, {}};
    for (const colmap_detail::Camera& c : colmap_detail::read_records(source).cameras) {
      const colmap_detail::Lens lens = colmap_detail::lens_of(c);
      cameras.push_back({lens.intrinsics, lens.distortion});
    }
    if (cameras.empty()) fail(file, "lists no camera");
  } else {
    cameras = read_yaml(file, contents);
  }
  for (const CameraFile& c : cameras) check(c, file);
  return cameras;
}

std::string why_not_exact(CameraFormat format, const CameraFile& c) {
  const Distortion& d = c.distortion;
  if (format == CameraFormat::kOpenCv) return "";
  if (c.intrinsics.skew_px != 0) return to_string(format) + " cannot hold a skewed camera matrix";
  if (format == CameraFormat::kKalibr && !d.fisheye && (d.k3 != 0 || !d.has_five_coefficients()))
    return "kalibr's radtan holds k1, k2, p1, p2 only; calibrate with --distortion radtan4";
  return "";
}

void write_camera_file(const path& file, CameraFormat format,
                       const std::vector<CameraFile>& cameras,
                       const std::optional<RigidTransform>& T_second_first) {
  if (cameras.empty() || (format == CameraFormat::kOpenCv && cameras.size() > 1))
    throw ArgumentError("an OpenCV file holds one camera, and every file at least one",
                        "write one file per camera");
  for (const CameraFile& c : cameras)
    if (const std::string reason = why_not_exact(format, c); !reason.empty())
      throw ArgumentError(file.string() + ": not written: " + reason, "or use another format");
  if (format == CameraFormat::kColmap) {
    std::string out = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS\n";
    for (std::size_t i = 0; i < cameras.size(); ++i)
      out += colmap_detail::camera_line(
                 colmap_detail::camera_of(i + 1, cameras[i].intrinsics, cameras[i].distortion)) +
             "\n";
    write_text_atomically(file, out);
  } else {
    write_text_atomically(file, format == CameraFormat::kOpenCv
                                    ? opencv_text(cameras[0])
                                    : kalibr_text(cameras, T_second_first));
  }
}

}  // namespace wheatstone
