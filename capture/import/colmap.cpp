#include "capture/import/colmap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "capture/import/colmap_lens.h"
#include "capture/import/colmap_records.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

using colmap_detail::Camera;
using colmap_detail::Image;
using colmap_detail::kPixelCentre;
using colmap_detail::Lens;
using colmap_detail::lens_of;

bool all_finite(const auto& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
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

std::vector<KnownPoint> known_points(const ColmapModel& model) {
  std::vector<KnownPoint> points;
  for (const ColmapObservation& o : model.observations)
    points.push_back({o.view, model.points[o.point].p_world_mm, o.pixel});
  return points;
}

double median_reprojection_error_px(const ColmapModel& model, std::size_t view) {
  std::vector<KnownPoint> points = known_points(model);
  std::erase_if(points, [&](const KnownPoint& p) { return p.view != view; });
  return median_error_px(model.views, points);
}
double median_reprojection_error_px(const ColmapModel& model) {
  return median_error_px(model.views, known_points(model));
}

}  // namespace wheatstone
