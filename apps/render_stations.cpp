// The stations between a light field and the panels.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "apps/stations.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "display/depth_filtering.h"
#include "display/dual_modulation.h"
#include "rendering/light_field/drlf_renderer.h"
#include "rendering/light_field/focus.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone::apps {

namespace {

VirtualCamera as_camera(const EyeDisplayCalibration& eye) {
  return {eye.intrinsics.K(), eye.T_eye_rsb, eye.intrinsics.width_px, eye.intrinsics.height_px};
}

VirtualCamera as_camera(const LightFieldView& view) {
  return {view.intrinsics.K(), view.T_camera_world, view.intrinsics.width_px,
          view.intrinsics.height_px};
}

/// Renders with the shader or its twin; the GL context lives as long as this object.
class Drlf {
 public:
  Drlf(const std::vector<LightFieldView>& views, bool use_gpu) : views_(views) {
    if (!use_gpu) return;
    try {
      context_.emplace();
    } catch (const GraphicsError& e) {
      throw GraphicsError(e.what(), "or use --cpu, which needs no OpenGL");
    }
    renderer_.emplace(*context_, views);
  }
  DrlfResult render(const VirtualCamera& camera, const DrlfOptions& options) {
    return renderer_ ? renderer_->render(camera, options)
                     : render_drlf_cpu(views_, camera, options);
  }

 private:
  const std::vector<LightFieldView>& views_;
  std::optional<OffscreenContext> context_;
  std::optional<DrlfRenderer> renderer_;
};

double distance_along_axis_mm(const RigidTransform& T_camera_world, const PlaneInWorld& plane) {
  const Eigen::Vector3d centre = camera_centre(T_camera_world);
  const Eigen::Vector3d forward = T_camera_world.R.row(2);
  return (plane.offset_mm - plane.normal.dot(centre)) / plane.normal.dot(forward);
}

double near_weight(const std::vector<PanelModel>& panels, Eye eye, double distance_mm) {
  const PanelModel& near = panels[index_of({eye, Plane::kNear})];
  const PanelModel& far = panels[index_of({eye, Plane::kFar})];
  const std::array planes = {vergence_at(near.distance), vergence_at(far.distance)};
  return plane_weights(planes, vergence_at(Length::of(distance_mm)))[0];
}

void write_target(const Dataset& dataset, DisplayId id, const RgbImage& light) {
  write_exr(dataset.file("targets/" + to_string(id) + ".exr"), light);
}

void write_target_report(const Dataset& dataset, const std::string& method,
                         const TargetReport& report) {
  write_json(dataset.file("targets.json"), "wheatstone-targets/1",
             {{"method", method},
              {"focal_distance_mm", report.focal_distance_mm},
              {"near_weight", report.near_weight},
              {"smallest_coverage", report.smallest_coverage}});
}

// Half a picture pixel of blur per wanted pixel of minification keeps detail from aliasing.
RgbImage warp_pinhole(const RgbImage& picture, const Intrinsics& k, const Eigen::Matrix3d& R,
                      const Intrinsics& wanted) {
  const Eigen::Matrix3d H_picture_wanted = k.K() * R * wanted.K().inverse();
  const double shrink = k.fx_px / wanted.fx_px;
  cv::Mat3f source = picture.pixels;
  if (shrink > 1) cv::GaussianBlur(source, source, {}, 0.5 * shrink);
  RgbImage out(wanted.width_px, wanted.height_px);
  cv::warpPerspective(source, out.pixels, to_cv(H_picture_wanted), out.pixels.size(),
                      cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  return out;
}

}  // namespace

RgbImage resample_pinhole(const LightFieldView& view, const Intrinsics& wanted) {
  return warp_pinhole(view.light_cd_m2, view.intrinsics, Eigen::Matrix3d::Identity(), wanted);
}

TargetReport render_drlf(const Dataset& dataset, std::optional<double> focal_z_mm, bool use_gpu,
                         const Progress& progress) {
  const std::vector<LightFieldView> views = load_light_field(dataset);
  const std::vector<EyeDisplayCalibration> eyes = dataset.read_eyes();
  const std::vector<PanelModel> panels = dataset.read_displays();
  make_folder(dataset.file("targets"));

  const VirtualCamera middle = as_camera(views[views.size() / 2]);
  DrlfOptions options;
  if (focal_z_mm) {
    options.focal_plane = {Eigen::Vector3d::UnitZ(), *focal_z_mm};
  } else {
    const double camera_z = camera_centre(middle.T_camera_world).z();
    PlaneInWorld found = find_focal_plane(views, middle.T_camera_world,
                                          std::max(50.0, camera_z - 360), camera_z + 20, 48);
    // The planes of the display face the viewer, so only the depth of the found plane is used.
    const double depth = distance_along_axis_mm(middle.T_camera_world, found);
    options.focal_plane = {Eigen::Vector3d::UnitZ(), camera_z - depth};
  }

  Drlf drlf(views, use_gpu);
  TargetReport report;
  for (DisplayId id : kDisplays) {
    const EyeDisplayCalibration& eye = eyes[index_of(id)];
    // Both displays of an eye share its centre; the far one's field lies inside the near one's.
    const double distance = camera_centre(eyes[index_of({id.eye, Plane::kFar})].T_eye_rsb).z() -
                            options.focal_plane.offset_mm;
    report.focal_distance_mm = distance;
    report.near_weight = near_weight(panels, id.eye, distance);
    const double weight = id.plane == Plane::kNear ? report.near_weight : 1 - report.near_weight;
    const DrlfResult seen = drlf.render(as_camera(eye), options);
    if (id.plane == Plane::kFar)
      report.smallest_coverage =
          std::min(report.smallest_coverage,
                   static_cast<double>(cv::countNonZero(seen.coverage.pixels > 0)) /
                       (seen.coverage.width() * seen.coverage.height()));
    write_target(dataset, id, weighted(seen.light_cd_m2, weight));
    progress("render " + to_string(id), index_of(id) + 1, 4);
  }
  write_target_report(dataset, "drlf", report);
  return report;
}

TargetReport render_rgbd(const Dataset& dataset) {
  const std::vector<LightFieldView> views = load_light_field(dataset);
  const std::vector<EyeDisplayCalibration> eyes = dataset.read_eyes();
  const std::vector<PanelModel> panels = dataset.read_displays();
  make_folder(dataset.file("targets"));
  for (DisplayId id : kDisplays) {
    const LightFieldView* view = nullptr;
    for (const LightFieldView& v : views)
      if (v.name == to_string(id.eye)) view = &v;
    if (view == nullptr)
      throw FileError(dataset.file("views.json"), "has no view named " + to_string(id.eye),
                      "import a stereo frame first");
    const std::vector<ExrView> depth =
        read_exr_views(dataset.file("depth/" + to_string(id.eye) + ".exr"));
    const ScalarImage& z_mm = depth.at(0).channels.at("Z");
    ScalarImage weight(z_mm.width(), z_mm.height());
    for (int r = 0; r < z_mm.height(); ++r)
      for (int c = 0; c < z_mm.width(); ++c) {
        const double z = z_mm.pixels(r, c);
        // Pixels without depth lie behind everything and belong to the far plane.
        const double near = z > 0 ? near_weight(panels, id.eye, z) : 0;
        weight.pixels(r, c) = static_cast<float>(id.plane == Plane::kNear ? near : 1 - near);
      }
    const RgbImage light = weighted(view->light_cd_m2, weight);
    // The picture was taken from the eye's own centre, so a rotation maps it to the display. The
    // frame's camera looks straight ahead.
    const EyeDisplayCalibration& eye = eyes[index_of(id)];
    const RgbImage target =
        warp_pinhole(light, view->intrinsics, straight_R_camera_rsb() * eye.T_eye_rsb.R.transpose(),
                     eye.intrinsics);
    write_target(dataset, id, target);
  }
  TargetReport report;
  write_target_report(dataset, "rgbd", report);
  return report;
}

PresentReport split_to_drive_frames(const Dataset& dataset) {
  const std::vector<PanelModel> panels = dataset.read_displays();
  make_folder(dataset.file("drive"));
  PresentReport report;
  nlohmann::json frames = nlohmann::json::array();
  for (DisplayId id : kDisplays) {
    const RgbImage target = read_exr(dataset.file("targets/" + to_string(id) + ".exr"));
    const DualDrive drive = split_dual_modulation(panels[index_of(id)], target);
    report.above_peak_px += drive.above_peak_px;
    report.below_black_px += drive.below_black_px;
    for (const bool projector : {false, true}) {
      const std::string file =
          "drive/" + to_string(id) + (projector ? "_projector.png" : "_lcd.png");
      write_drive_png(dataset.file(file), projector ? drive.projector : drive.lcd);
      frames.push_back({{"display", to_string(id)},
                        {"modulator", projector ? "projector" : "lcd"},
                        {"file", file},
                        {"bits", 8}});
    }
  }
  write_json(dataset.file("drive.json"), "wheatstone-drive/1",
             {{"frames", frames},
              {"above_peak_px", report.above_peak_px},
              {"below_black_px", report.below_black_px}});
  return report;
}

namespace {

struct PanelFrames {
  DriveImage lcd, projector;
};

/// Both displays of an eye add up; their brightest points may lie on one line of sight.
void require_below_limit(const Rig& rig, const std::array<PanelFrames, 4>& frames) {
  if (!rig.luminance_limit) return;
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    double most_cd_m2 = 0;
    for (const Plane plane : {Plane::kNear, Plane::kFar}) {
      const auto i = static_cast<std::size_t>(index_of({eye, plane}));
      double brightest = 0;
      cv::minMaxLoc(
          luminance_cd_m2(simulate_light(rig.panel_models[i], frames[i].projector, frames[i].lcd))
              .pixels,
          nullptr, &brightest);
      most_cd_m2 += brightest;
    }
    if (most_cd_m2 > rig.luminance_limit->value())
      throw DeviceError(
          DeviceError::Kind::kOutOfRange,
          fmt::format("the frames would show the {} eye up to {:.4g} cd/m², more than the {:.4g} "
                      "that are allowed",
                      to_string(eye), most_cd_m2, rig.luminance_limit->value()),
          "darken the stimulus; nothing was shown");
  }
}

}  // namespace

void present(const Dataset& dataset, const Rig& rig) {
  std::array<PanelFrames, 4> frames;
  for (DisplayId id : kDisplays)
    frames[static_cast<std::size_t>(index_of(id))] = {
        read_drive_png(dataset.file("drive/" + to_string(id) + "_lcd.png")),
        read_drive_png(dataset.file("drive/" + to_string(id) + "_projector.png"))};
  require_below_limit(rig, frames);
  const Nanoseconds at = rig.clock.now_ns();
  try {
    for (DisplayId id : kDisplays) {
      const PanelFrames& f = frames[static_cast<std::size_t>(index_of(id))];
      rig.panel(id, PanelOutput::Modulator::kLcd).show(f.lcd, at);
      rig.panel(id, PanelOutput::Modulator::kProjector).show(f.projector, at);
    }
  } catch (...) {
    make_safe(rig);  // half a stimulus is none
    throw;
  }
}

LeftOutReport render_left_out(const Dataset& dataset, const std::string& name,
                              std::optional<double> focal_distance_mm, bool use_gpu) {
  double white = dataset.read_manifest().white_cd_m2;
  std::vector<LightFieldView> views = load_light_field(dataset);
  const auto found = std::find_if(views.begin(), views.end(),
                                  [&](const LightFieldView& v) { return v.name == name; });
  if (found == views.end())
    throw ArgumentError("the light field has no view named '" + name + "'",
                        "use a name from " + dataset.file("views.json").string());
  const LightFieldView left_out = *found;
  // A capture has no white of its own; its brightest light then is code 255.
  if (white == 0) cv::minMaxLoc(left_out.light_cd_m2.pixels.reshape(1), nullptr, &white);
  views.erase(found);
  if (views.size() < 2)
    throw ArgumentError("leaving out a view needs at least three views", "import more");
  std::sort(views.begin(), views.end(), [&](const LightFieldView& a, const LightFieldView& b) {
    const Eigen::Vector3d c = camera_centre(left_out.T_camera_world);
    return (camera_centre(a.T_camera_world) - c).norm() <
           (camera_centre(b.T_camera_world) - c).norm();
  });

  const VirtualCamera camera = as_camera(left_out);
  DrlfOptions options;
  if (focal_distance_mm) {
    const Eigen::Vector3d forward = left_out.T_camera_world.R.row(2);
    options.focal_plane = {
        forward, forward.dot(camera_centre(left_out.T_camera_world)) + *focal_distance_mm};
  } else {
    const double step =
        (camera_centre(views[0].T_camera_world) - camera_centre(left_out.T_camera_world)).norm();
    // From a twentieth of a pixel of parallax between neighbours to four pictures' width (cameras
    // that turn towards a near object still share it), in steps of a pixel: textures repeat, so a
    // coarser sweep may pass the true depth by.
    const double f = left_out.intrinsics.fx_px, largest_px = 4.0 * camera.width;
    options.focal_plane =
        find_focal_plane(views, left_out.T_camera_world, f * step / largest_px, f * step / 0.05,
                         std::max(64, static_cast<int>(largest_px)));
  }
  Drlf drlf(views, use_gpu);
  const DrlfResult result = drlf.render(camera, options);

  LeftOutReport report;
  report.view = name;
  report.focal_distance_mm = distance_along_axis_mm(left_out.T_camera_world, options.focal_plane);
  report.nearest = views[0].name;
  report.second = views[1].name;
  report.reference = left_out.light_cd_m2;
  report.rendered = result.light_cd_m2;
  const cv::Mat1b mask = result.coverage.pixels > 0;
  const RgbImage average(
      cv::Mat3f(0.5 * (views[0].light_cd_m2.pixels + views[1].light_cd_m2.pixels)));
  report.psnr_drlf_db = srgb_psnr(result.light_cd_m2, left_out.light_cd_m2, white, &mask);
  report.psnr_nearest_db = srgb_psnr(views[0].light_cd_m2, left_out.light_cd_m2, white, &mask);
  report.psnr_average_db = srgb_psnr(average, left_out.light_cd_m2, white, &mask);
  return report;
}

}  // namespace wheatstone::apps
