#include "capture/import/colmap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "capture/import/colmap_records.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

using colmap_detail::Camera;
using colmap_detail::Image;
using colmap_detail::Place;

constexpr double kPixelCentre = 0.5;  // COLMAP's coordinate of the first pixel's centre

bool all_finite(const auto& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

struct Lens {
  Intrinsics intrinsics;
  Distortion distortion;
};

Lens lens_of(const Camera& c) {
  const auto& p = c.parameters;
  if (c.width < 1 || c.height < 1 || c.width > 65536 || c.height > 65536)
    c.place.fail("a picture size outside 1..65536 px");
  if (!all_finite(p)) c.place.fail("a camera parameter that is not a number");
  const bool two_focal_lengths = c.model == "PINHOLE" || c.model == "OPENCV";
  const std::size_t centre = two_focal_lengths ? 2 : 1;
  Lens lens;
  lens.intrinsics = {p[0],
                     p[centre - 1],
                     0,
                     p[centre] - kPixelCentre,
                     p[centre + 1] - kPixelCentre,
                     static_cast<int>(c.width),
                     static_cast<int>(c.height)};
  if (!(p[0] > 0) || !(p[centre - 1] > 0)) c.place.fail("a focal length that is not above 0");
  if (p.size() > centre + 2) lens.distortion.k1 = p[centre + 2];
  if (p.size() > centre + 3) lens.distortion.k2 = p[centre + 3];
  if (c.model == "OPENCV") {
    lens.distortion.p1 = p[6];
    lens.distortion.p2 = p[7];
  }
  return lens;
}

RigidTransform pose_of(const Image& image, double mm_per_unit) {
  const auto& q = image.q_wxyz;
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!all_finite(q) || !(std::abs(rotation.norm() - 1) < 0.01))
    image.place.fail("a rotation quaternion that is not of length 1");
  if (!all_finite(image.t)) image.place.fail("a translation that is not a number");
  return {rotation.normalized().toRotationMatrix(),
          mm_per_unit * Eigen::Vector3d(image.t[0], image.t[1], image.t[2])};
}

void check_name(const Image& image) {
  const std::filesystem::path name(image.name);
  const bool leaves = name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
  if (image.name.empty() || leaves || image.name.find('\0') != std::string::npos)
    image.place.fail("a picture name that is empty or leaves the picture folder");
}

double median_error(const ColmapModel& model, std::size_t first, std::size_t last) {
  std::vector<double> errors;
  for (const auto& o : model.observations) {
    if (o.view < first || o.view > last) continue;
    const ImportedView& view = model.views[o.view];
    const Eigen::Vector3d p = view.T_camera_world * model.points[o.point].p_world_mm;
    const double e = p.z() > 0 ? (project(view.intrinsics, view.distortion, p) - o.pixel).norm()
                               : std::numeric_limits<double>::infinity();
    errors.push_back(std::isnan(e) ? std::numeric_limits<double>::infinity() : e);
  }
  if (errors.empty())
    throw ArgumentError("no tracked points to reproject", "import a model with its points3D file");
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace

ColmapModel parse_colmap(const ColmapSource& source, const std::filesystem::path& pictures,
                         double mm_per_unit) {
  if (!(mm_per_unit > 0 && std::isfinite(mm_per_unit)))
    throw ArgumentError("the scale of a COLMAP model must be above 0", "give mm per COLMAP unit");
  const auto records = colmap_detail::read_records(source);

  std::unordered_map<std::uint64_t, Lens> lenses;
  for (const Camera& c : records.cameras)
    if (!lenses.emplace(c.id, lens_of(c)).second) c.place.fail("a camera number used twice");

  ColmapModel model;
  std::unordered_map<std::uint64_t, std::size_t> point_index;
  for (const auto& p : records.points) {
    if (!all_finite(p.xyz)) p.place.fail("a point that is not a number");
    if (!point_index.emplace(p.id, model.points.size()).second)
      p.place.fail("a point number used twice");
    model.points.push_back(
        {p.id, mm_per_unit * Eigen::Vector3d(p.xyz[0], p.xyz[1], p.xyz[2]), p.rgb, p.error});
  }

  std::unordered_set<std::uint64_t> image_ids;
  for (const Image& image : records.images) {
    if (!image_ids.insert(image.id).second) image.place.fail("an image number used twice");
    const auto lens = lenses.find(image.camera);
    if (lens == lenses.end()) image.place.fail("a camera number that the cameras file lacks");
    check_name(image);
    std::filesystem::path path = pictures / image.name;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) {
      model.missing_files.push_back(image.name);
      path.clear();
    }
    for (const auto& o : image.observations) {
      const auto point = point_index.find(o.point);
      if (point == point_index.end()) image.place.fail("a point number that points3D lacks");
      if (!std::isfinite(o.x) || !std::isfinite(o.y))
        image.place.fail("an observation that is not a number");
      model.observations.push_back(
          {model.views.size(), point->second, {o.x - kPixelCentre, o.y - kPixelCentre}});
    }
    model.views.push_back({image.name, path, lens->second.intrinsics, lens->second.distortion,
                           pose_of(image, mm_per_unit)});
  }
  return model;
}

ColmapModel read_colmap(const std::filesystem::path& folder, const std::filesystem::path& pictures,
                        double mm_per_unit) {
  ColmapSource source;
  source.folder = folder;
  source.binary = std::filesystem::exists(folder / "cameras.bin");
  const std::string ending = source.binary ? ".bin" : ".txt";
  if (!source.binary && !std::filesystem::exists(folder / "cameras.txt"))
    throw FileError(folder, "holds neither cameras.bin nor cameras.txt",
                    "give the folder of a COLMAP model (often sparse/0)");
  source.cameras = read_text(folder / ("cameras" + ending));
  source.images = read_text(folder / ("images" + ending));
  source.points = read_text(folder / ("points3D" + ending));
  return parse_colmap(source, pictures, mm_per_unit);
}

double median_reprojection_error_px(const ColmapModel& model, std::size_t view) {
  return median_error(model, view, view);
}
double median_reprojection_error_px(const ColmapModel& model) {
  return median_error(model, 0, std::numeric_limits<std::size_t>::max());
}

}  // namespace wheatstone
