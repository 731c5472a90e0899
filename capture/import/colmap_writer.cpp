#include "capture/import/colmap_writer.h"

#include <fmt/format.h>

#include <type_traits>

#include "capture/import/colmap_lens.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

using namespace colmap_detail;

/// Model numbers of the binary format, for the models that camera_of() makes.
int model_number(const std::string& model) {
  return model == "PINHOLE" ? 1 : model == "OPENCV" ? 4 : model == "OPENCV_FISHEYE" ? 5 : 6;
}

/// A point with where it was seen: image index and the observation's index in that image.
struct Track {
  Point point;
  std::vector<std::pair<std::size_t, std::size_t>> seen;
};

struct Model {
  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Track> tracks;
};

Model model_of(std::span<const ImportedView> views, std::span<const KnownPoint> points) {
  Model m;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Camera camera = camera_of(m.cameras.size() + 1, views[v].intrinsics, views[v].distortion);
    for (const Camera& known : m.cameras)
      if (known.model == camera.model && known.parameters == camera.parameters &&
          known.width == camera.width && known.height == camera.height)
        camera.id = known.id;
    Image image;
    image.id = v + 1;
    image.camera = camera.id;
    if (camera.id > m.cameras.size()) m.cameras.push_back(std::move(camera));
    const RigidTransform& T = views[v].T_camera_world;
    const Eigen::Quaterniond q(T.R);
    image.q_wxyz = {q.w(), q.x(), q.y(), q.z()};
    image.t = {T.t_mm.x(), T.t_mm.y(), T.t_mm.z()};
    image.name = views[v].path.empty() ? views[v].name : views[v].path.filename().string();
    m.images.push_back(std::move(image));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const KnownPoint& p = points[i];
    if (i == 0 || p.p_world_mm != points[i - 1].p_world_mm) {
      Track track;
      track.point.id = m.tracks.size() + 1;
      track.point.xyz = {p.p_world_mm.x(), p.p_world_mm.y(), p.p_world_mm.z()};
      m.tracks.push_back(std::move(track));
    }
    auto& seen = m.images[p.view].observations;
    m.tracks.back().seen.emplace_back(p.view, seen.size());
    seen.push_back({p.px.x() + kPixelCentre, p.px.y() + kPixelCentre, m.tracks.back().point.id});
  }
  return m;
}

ColmapSource text_files(const Model& m) {
  ColmapSource out;
  out.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS\n";
  for (const Camera& c : m.cameras) out.cameras += camera_line(c) + "\n";
  out.images =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then X Y POINT3D_ID of each observation\n";
  for (const Image& i : m.images) {
    out.images += fmt::format("{} {} {} {} {}\n", i.id, fmt::join(i.q_wxyz, " "),
                              fmt::join(i.t, " "), i.camera, i.name);
    std::string line;
    for (const Observation& o : i.observations)
      line += fmt::format("{}{} {} {}", line.empty() ? "" : " ", o.x, o.y, o.point);
    out.images += line + "\n";
  }
  out.points = "# POINT3D_ID X Y Z R G B ERROR, then IMAGE_ID POINT2D_IDX of each observation\n";
  for (const Track& t : m.tracks) {
    out.points += fmt::format("{} {} 255 255 255 0", t.point.id, fmt::join(t.point.xyz, " "));
    for (const auto& [image, index] : t.seen)
      out.points += fmt::format(" {} {}", m.images[image].id, index);
    out.points += "\n";
  }
  return out;
}

/// Appends values as they lie in memory, little-endian.
template <class... T>
void put(std::string& to, const T&... values) {
  static_assert((std::is_trivially_copyable_v<T> && ...));
  (to.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
}

ColmapSource binary_files(const Model& m) {
  ColmapSource out;
  put(out.cameras, std::uint64_t{m.cameras.size()});
  for (const Camera& c : m.cameras) {
    put(out.cameras, static_cast<std::uint32_t>(c.id), model_number(c.model), c.width, c.height);
    for (const double p : c.parameters) put(out.cameras, p);
  }
  put(out.images, std::uint64_t{m.images.size()});
  for (const Image& i : m.images) {
    put(out.images, static_cast<std::uint32_t>(i.id), i.q_wxyz, i.t,
        static_cast<std::uint32_t>(i.camera));
    out.images += i.name + '\0';
    put(out.images, std::uint64_t{i.observations.size()});
    for (const Observation& o : i.observations) put(out.images, o.x, o.y, o.point);
  }
  put(out.points, std::uint64_t{m.tracks.size()});
  for (const Track& t : m.tracks) {
    put(out.points, t.point.id, t.point.xyz, '\xff', '\xff', '\xff', 0.0,
        std::uint64_t{t.seen.size()});
    for (const auto& [image, index] : t.seen)
      put(out.points, static_cast<std::uint32_t>(m.images[image].id),
          static_cast<std::uint32_t>(index));
  }
  return out;
}

}  // namespace

void write_colmap(const std::filesystem::path& folder, bool binary,
                  std::span<const ImportedView> views, std::span<const KnownPoint> points) {
  if (views.empty()) throw ArgumentError("a model without views says nothing", "name a view");
  const Model model = model_of(views, points);
  const ColmapSource files = binary ? binary_files(model) : text_files(model);
  const std::string ending = binary ? ".bin" : ".txt";
  make_folder(folder);
  write_text_atomically(folder / ("points3D" + ending), files.points);
  write_text_atomically(folder / ("images" + ending), files.images);
  write_text_atomically(folder / ("cameras" + ending), files.cameras);
}

}  // namespace wheatstone
