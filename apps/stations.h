#pragma once
// The stations of the light's way, each from dataset folder to dataset folder.

#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/shard.h"
#include "calib/pose_solver.h"
#include "calib/rail.h"
#include "capture/import/imported_view.h"
#include "core/dataset.h"
#include "hardware/rig.h"

namespace wheatstone::apps {

using Progress = std::function<void(const std::string& what, int done, int total)>;

/// A view and a share of its pixels.
struct ViewShare {
  std::string view;
  double share = 0;
};
struct MergeReport {
  int views_of_folder = 0, merged = 0, there_already = 0;  // of the last two: the shard's views
  // The shard's worst views, merged now or before: saturated even in the shortest exposure; below
  // two standard deviations.
  ViewShare most_saturated, most_underexposed;
  std::vector<std::string> notes;  // why a view was merged again; exposures that contradict
  // Of the views merged now, where the capture was planned for a signal-to-noise ratio: the
  // smallest share of a view's photosites that reach it, by the merge's own standard deviations.
  double signal_to_noise = 0, coverage = 0;  // planned for; 0 if the exposures were given by hand
  double least_share = 1;
};
/// Where each view shows the monitor patch, px of its raw frames; empty: the lamps are taken as
/// steady.
using MonitorPatches = std::map<std::string, cv::Rect>;
/// CSV with the columns view, x_px, y_px, width_px, height_px. Errors: FileError, ArgumentError.
MonitorPatches read_monitor_patches(const std::filesystem::path&);

/// raw/*.png to hdr/<view>.exr, cd/m^2, with its record hdr/<view>.json: the shard's views. A file
/// that is there is kept if it is what its record says and was made from what it would be made from
/// now; otherwise it is made again. With monitor patches every view is brought to the lamps of the
/// first one. Errors: FileError: no capture; a frame that is missing or not what the session's
/// journal says; or naming the view's frames. ArgumentError, before anything is written, unless
/// there is a patch inside of every view and none besides; later for a view whose patch is bad.
MergeReport merge(const Dataset&, const Progress&, Shard = {}, const MonitorPatches& = {});

struct PoseCalibrationOptions {
  PoseOptions solver;
  bool skip_bad_views = false;  // leave them out instead of stopping
  bool crop_per_view = false;   // each view as small as it can be, instead of all of one size
};
/// A view whose markers contradict where the LEDs stand, the other views, or where the rail put it.
struct BadView {
  std::string name, reason;
};
struct PoseCalibration {
  PoseSolution solution;
  std::vector<CapturedView> frames;  // the views of the solution, in its order
  std::vector<BadView> bad_views;
  std::optional<RailReport> rail;  // if the views stand at different positions
  // Pixels of all views: as photographed, cropped to one size, and as they are now.
  std::int64_t photographed_px = 0, common_px = 0, cropped_px = 0;
};
/// Marker frames to poses.json, pose_report.json and, if the views stand at different positions,
/// rail.svg; then all views cropped to the same rectangle of the box: views/*.exr, views.json.
/// Errors: ArgumentError naming all bad views, unless they are skipped.
PoseCalibration calibrate_poses(const Dataset&, const Progress&,
                                const PoseCalibrationOptions& = {});

/// alignments.json to eyes.json.
std::vector<EyeDisplayCalibration> calibrate_eyes(const Dataset&);

/// The light field in views.json with its pictures loaded.
std::vector<LightFieldView> load_light_field(const Dataset&);
void store_light_field(const Dataset&, const std::vector<LightFieldView>&);

/// What the four displays shall show: targets/<display>.exr and targets.json.
struct TargetReport {
  double focal_distance_mm = 0;  // eye to the focal plane along the optical axis, 0 if per pixel
  double near_weight = 0;
  double smallest_coverage = 1;  // worst display: share of its pixels that some view covers
};
/// DRLF with its focal plane `focal_z_mm` in rsb; without it the plane is found by the views' own
/// agreement. use_gpu: the shader; otherwise its CPU twin.
TargetReport render_drlf(const Dataset&, std::optional<double> focal_z_mm, bool use_gpu,
                         const Progress&);
/// Colour and depth of an imported stereo frame, split per pixel.
TargetReport render_rgbd(const Dataset&);
/// A pinhole picture seen through another pinhole with the same centre and axes.
RgbImage resample_pinhole(const LightFieldView&, const Intrinsics& wanted);

/// targets/*.exr to the eight drive frames drive/*.png and drive.json.
struct PresentReport {
  int above_peak_px = 0, below_black_px = 0;  // over all four displays
};
PresentReport split_to_drive_frames(const Dataset&);
/// Shows the eight frames of the folder on the rig, all or none: DeviceError kOutOfRange if the rig
/// has a luminance limit and an eye could be shown more, by the panels' models.
void present(const Dataset&, const Rig&);

/// Left-out view of a light field: what DRLF makes of the others, and two plain answers.
struct LeftOutReport {
  std::string view;
  double focal_distance_mm = 0;
  double psnr_drlf_db = 0, psnr_nearest_db = 0, psnr_average_db = 0;  // sRGB, 8 bit, peak 255
  std::string nearest, second;
  RgbImage reference, rendered;
};
LeftOutReport render_left_out(const Dataset&, const std::string& view,
                              std::optional<double> focal_distance_mm, bool use_gpu);

}  // namespace wheatstone::apps
