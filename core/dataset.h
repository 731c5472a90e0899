#pragma once
// The dataset folder: where each file stands and how it is read and written. docs/dataset.md
// describes every key. Readers throw FileError naming file, key and remedy.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/rig_types.h"

namespace wheatstone {

/// dataset.json: what the folder is.
struct DatasetManifest {
  std::string kind;  // "capture", "light-field" or "stereo-rgbd"
  std::string scene;
  std::uint64_t seed = 0;
  double scale = 1;
  std::string source;      // where the input came from, for people
  double white_cd_m2 = 0;  // luminance given to full white of encoded input; 0 for captures
  double mm_per_unit = 1;  // length of the input's own unit
};

/// frames.json: what was exposed. Paths are relative to the dataset folder.
struct ExposureRecord {
  std::string file;
  double exposure_s = 0;
};
struct CapturedView {
  std::string name;
  double commanded_mm = 0, reached_mm = 0;  // frame `gantry`
  std::vector<ExposureRecord> exposures;
  ExposureRecord marker_frame;
};

/// camera.json and displays.json (in the order of kDisplays), wherever they stand.
CameraProfile read_camera_profile(const std::filesystem::path&);
void write_camera_profile(const std::filesystem::path&, const CameraProfile&);
std::vector<PanelModel> read_panel_models(const std::filesystem::path&);

/// A dataset folder by its root path; knows names, holds no data.
class Dataset {
 public:
  explicit Dataset(std::filesystem::path root) : root_(std::move(root)) {}
  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path file(const std::string& relative) const { return root_ / relative; }

  DatasetManifest read_manifest() const;
  void write_manifest(const DatasetManifest&) const;

  CameraProfile read_camera() const;  // camera.json
  void write_camera(const CameraProfile&) const;

  std::vector<CapturedView> read_frames() const;  // frames.json
  void write_frames(const std::vector<CapturedView>&) const;

  /// landmarks.json: marker LEDs and near crosses in rsb, mm.
  struct Landmarks {
    std::vector<Eigen::Vector3d> markers_mm, near_crosses_mm;
  };
  Landmarks read_landmarks() const;
  void write_landmarks(const Landmarks&) const;

  std::vector<PanelModel> read_displays() const;  // displays.json, order of kDisplays
  void write_displays(const std::vector<PanelModel>&) const;

  std::vector<std::vector<Alignment>> read_alignments() const;  // alignments.json, kDisplays
  void write_alignments(const std::vector<std::vector<Alignment>>&) const;

  std::vector<EyeDisplayCalibration> read_eyes() const;  // eyes.json, order of kDisplays
  void write_eyes(const std::vector<EyeDisplayCalibration>&) const;

 private:
  std::filesystem::path root_;
};

}  // namespace wheatstone
