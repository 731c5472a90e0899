#include "core/dataset.h"

#include "core/error.h"
#include "core/json.h"

namespace wheatstone {

using nlohmann::json;
using std::filesystem::path;

namespace {

const json& array_of(const json& object, const std::string& key, std::size_t size,
                     const path& file) {
  if (!object.is_object() || !object.contains(key)) throw_bad_key(file, key, "is missing");
  const json& value = object.at(key);
  if (!value.is_array()) throw_bad_key(file, key, "must be a list");
  if (size != 0 && value.size() != size)
    throw_bad_key(file, key, "must have " + std::to_string(size) + " entries");
  return value;
}

json to_json(const Intrinsics& k) {
  return {{"fx_px", k.fx_px},        {"fy_px", k.fy_px}, {"skew_px", k.skew_px},
          {"cx_px", k.cx_px},        {"cy_px", k.cy_px}, {"width_px", k.width_px},
          {"height_px", k.height_px}};
}

Intrinsics intrinsics_from_json(const json& j, const path& file) {
  Intrinsics k{json_get<double>(j, "fx_px", file),   json_get<double>(j, "fy_px", file),
               json_get<double>(j, "skew_px", file), json_get<double>(j, "cx_px", file),
               json_get<double>(j, "cy_px", file),   json_get<int>(j, "width_px", file),
               json_get<int>(j, "height_px", file)};
  if (k.fx_px == 0 || k.fy_px == 0 || k.width_px <= 0 || k.height_px <= 0)
    throw_bad_key(file, "intrinsics", "needs focal lengths and a size above zero");
  return k;
}

json points_to_json(const std::vector<Eigen::Vector3d>& points) {
  json list = json::array();
  for (const Eigen::Vector3d& p : points) list.push_back(wheatstone::to_json(p));
  return list;
}

std::vector<Eigen::Vector3d> points_from_json(const json& list, const path& file,
                                              const std::string& key) {
  std::vector<Eigen::Vector3d> points;
  for (const json& p : list) points.push_back(vector3_from_json(p, file, key));
  return points;
}

}  // namespace

DatasetManifest Dataset::read_manifest() const {
  const path f = file("dataset.json");
  const json j = read_json(f, "wheatstone-dataset/1");
  DatasetManifest m;
  m.kind = json_get<std::string>(j, "kind", f);
  if (m.kind != "capture" && m.kind != "light-field" && m.kind != "stereo-rgbd")
    throw_bad_key(f, "kind", "must be capture, light-field or stereo-rgbd, not '" + m.kind + "'");
  m.scene = json_get<std::string>(j, "scene", f);
  m.seed = json_get<std::uint64_t>(j, "seed", f);
  m.scale = json_get<double>(j, "scale", f);
  m.source = json_get<std::string>(j, "source", f);
  m.white_cd_m2 = json_get<double>(j, "white_cd_m2", f);
  m.mm_per_unit = json_get<double>(j, "mm_per_unit", f);
  return m;
}

void Dataset::write_manifest(const DatasetManifest& m) const {
  write_json(file("dataset.json"), "wheatstone-dataset/1",
             {{"kind", m.kind},
              {"scene", m.scene},
              {"seed", m.seed},
              {"scale", m.scale},
              {"source", m.source},
              {"white_cd_m2", m.white_cd_m2},
              {"mm_per_unit", m.mm_per_unit}});
}

CameraProfile Dataset::read_camera() const {
  return read_camera_profile(file("camera.json"));
}

CameraProfile read_camera_profile(const path& f) {
  const json j = read_json(f, "wheatstone-camera/1");
  CameraProfile c;
  c.serial = json_get<std::string>(j, "serial", f);
  c.intrinsics = intrinsics_from_json(json_get<json>(j, "intrinsics", f), f);
  const auto d = json_get<std::vector<double>>(j, "distortion_k1_k2_p1_p2_k3", f);
  if (d.size() != 5) throw_bad_key(f, "distortion_k1_k2_p1_p2_k3", "must have 5 entries");
  c.distortion = {d[0], d[1], d[2], d[3], d[4]};
  c.pattern = bayer_pattern_from_string(json_get<std::string>(j, "bayer_pattern", f));
  c.black_dn = json_get<int>(j, "black_dn", f);
  c.white_dn = json_get<int>(j, "white_dn", f);
  c.dn_per_cd_m2_s = json_get<double>(j, "dn_per_cd_m2_s", f);
  if (c.white_dn <= c.black_dn || !(c.dn_per_cd_m2_s > 0))
    throw_bad_key(f, "white_dn", "must be above black_dn, and dn_per_cd_m2_s above 0");
  c.camera_from_bt709 =
      matrix_from_json(json_get<json>(j, "camera_from_bt709", f), 3, 3, f, "camera_from_bt709");
  c.dn_per_electron = json_get<std::array<double, 3>>(j, "dn_per_electron_rgb", f);
  c.read_noise_e = json_get<double>(j, "read_noise_e", f);
  c.adc_noise = json_get<double>(j, "adc_noise", f);
  return c;
}

void Dataset::write_camera(const CameraProfile& c) const {
  write_camera_profile(file("camera.json"), c);
}

void write_camera_profile(const path& f, const CameraProfile& c) {
  const Distortion& d = c.distortion;
  if (!d.has_five_coefficients())
    throw ArgumentError("camera.json holds k1, k2, p1, p2, k3 alone, and this lens has more",
                        "calibrate the capture camera with --distortion radtan5");
  write_json(f, "wheatstone-camera/1",
             {{"serial", c.serial},
              {"intrinsics", to_json(c.intrinsics)},
              {"distortion_k1_k2_p1_p2_k3", {d.k1, d.k2, d.p1, d.p2, d.k3}},
              {"bayer_pattern", to_string(c.pattern)},
              {"black_dn", c.black_dn},
              {"white_dn", c.white_dn},
              {"dn_per_cd_m2_s", c.dn_per_cd_m2_s},
              {"camera_from_bt709", wheatstone::to_json(Eigen::MatrixXd(c.camera_from_bt709))},
              {"dn_per_electron_rgb", c.dn_per_electron},
              {"read_noise_e", c.read_noise_e},
              {"adc_noise", c.adc_noise}});
}

std::vector<CapturedView> Dataset::read_frames() const {
  const path f = file("frames.json");
  const json j = read_json(f, "wheatstone-frames/1");
  const auto exposure = [&](const json& e) {
    return ExposureRecord{json_get<std::string>(e, "file", f),
                          json_get<double>(e, "exposure_s", f)};
  };
  std::vector<CapturedView> views;
  for (const json& v : array_of(j, "views", 0, f)) {
    CapturedView view;
    view.name = json_get<std::string>(v, "name", f);
    view.commanded_mm = json_get<double>(v, "commanded_mm", f);
    view.reached_mm = json_get<double>(v, "reached_mm", f);
    for (const json& e : array_of(v, "exposures", 0, f)) view.exposures.push_back(exposure(e));
    view.marker_frame = exposure(json_get<json>(v, "marker_frame", f));
    views.push_back(view);
  }
  if (views.empty()) throw_bad_key(f, "views", "is empty");
  return views;
}

void Dataset::write_frames(const std::vector<CapturedView>& views) const {
  const auto exposure = [](const ExposureRecord& e) {
    return json{{"file", e.file}, {"exposure_s", e.exposure_s}};
  };
  json list = json::array();
  for (const CapturedView& v : views) {
    json exposures = json::array();
    for (const ExposureRecord& e : v.exposures) exposures.push_back(exposure(e));
    list.push_back({{"name", v.name},
                    {"commanded_mm", v.commanded_mm},
                    {"reached_mm", v.reached_mm},
                    {"exposures", exposures},
                    {"marker_frame", exposure(v.marker_frame)}});
  }
  write_json(file("frames.json"), "wheatstone-frames/1", {{"views", list}});
}

Dataset::Landmarks Dataset::read_landmarks() const {
  const path f = file("landmarks.json");
  const json j = read_json(f, "wheatstone-landmarks/1");
  return {points_from_json(array_of(j, "markers_rsb_mm", 4, f), f, "markers_rsb_mm"),
          points_from_json(array_of(j, "near_crosses_rsb_mm", 0, f), f, "near_crosses_rsb_mm")};
}

void Dataset::write_landmarks(const Landmarks& l) const {
  write_json(file("landmarks.json"), "wheatstone-landmarks/1",
             {{"markers_rsb_mm", points_to_json(l.markers_mm)},
              {"near_crosses_rsb_mm", points_to_json(l.near_crosses_mm)}});
}

std::vector<PanelModel> Dataset::read_displays() const {
  return read_panel_models(file("displays.json"));
}

std::vector<PanelModel> read_panel_models(const path& f) {
  const json j = read_json(f, "wheatstone-displays/1");
  std::vector<PanelModel> panels;
  for (const json& p : array_of(j, "displays", 4, f)) {
    PanelModel m;
    m.id = display_from_string(json_get<std::string>(p, "id", f));
    if (!(m.id == kDisplays[panels.size()])) throw_bad_key(f, "id", "is out of order");
    m.distance = Length::of(json_get<double>(p, "distance_mm", f));
    m.width_mm = json_get<double>(p, "width_mm", f);
    m.height_mm = json_get<double>(p, "height_mm", f);
    m.lcd_width_px = json_get<int>(p, "lcd_width_px", f);
    m.lcd_height_px = json_get<int>(p, "lcd_height_px", f);
    m.projector_width_px = json_get<int>(p, "projector_width_px", f);
    m.projector_height_px = json_get<int>(p, "projector_height_px", f);
    m.H_lcd_projector =
        matrix_from_json(json_get<json>(p, "H_lcd_projector", f), 3, 3, f, "H_lcd_projector");
    for (const json& lobe : array_of(p, "psf", 0, f))
      m.psf.push_back(
          {json_get<double>(lobe, "sigma_lcd_px", f), json_get<double>(lobe, "weight", f)});
    m.peak_cd_m2 = json_get<double>(p, "peak_cd_m2", f);
    m.leak_cd_m2 = json_get<double>(p, "leak_cd_m2", f);
    m.lcd_black = json_get<double>(p, "lcd_black", f);
    m.projector_black = json_get<double>(p, "projector_black", f);
    m.lcd_gamma = json_get<double>(p, "lcd_gamma", f);
    m.projector_gamma = json_get<double>(p, "projector_gamma", f);
    panels.push_back(m);
  }
  return panels;
}

void Dataset::write_displays(const std::vector<PanelModel>& panels) const {
  json list = json::array();
  for (const PanelModel& m : panels) {
    json psf = json::array();
    for (const GaussianLobe& lobe : m.psf)
      psf.push_back({{"sigma_lcd_px", lobe.sigma_lcd_px}, {"weight", lobe.weight}});
    list.push_back({{"id", to_string(m.id)},
                    {"distance_mm", m.distance.value()},
                    {"width_mm", m.width_mm},
                    {"height_mm", m.height_mm},
                    {"lcd_width_px", m.lcd_width_px},
                    {"lcd_height_px", m.lcd_height_px},
                    {"projector_width_px", m.projector_width_px},
                    {"projector_height_px", m.projector_height_px},
                    {"H_lcd_projector", wheatstone::to_json(Eigen::MatrixXd(m.H_lcd_projector))},
                    {"psf", psf},
                    {"peak_cd_m2", m.peak_cd_m2},
                    {"leak_cd_m2", m.leak_cd_m2},
                    {"lcd_black", m.lcd_black},
                    {"projector_black", m.projector_black},
                    {"lcd_gamma", m.lcd_gamma},
                    {"projector_gamma", m.projector_gamma}});
  }
  write_json(file("displays.json"), "wheatstone-displays/1", {{"displays", list}});
}

std::vector<std::vector<Alignment>> Dataset::read_alignments() const {
  const path f = file("alignments.json");
  const json j = read_json(f, "wheatstone-alignments/1");
  std::vector<std::vector<Alignment>> all;
  for (DisplayId id : kDisplays) {
    std::vector<Alignment> marks;
    for (const json& m : array_of(j, to_string(id), 0, f))
      marks.push_back({vector3_from_json(json_get<json>(m, "p_rsb_mm", f), f, "p_rsb_mm"),
                       vector2_from_json(json_get<json>(m, "lcd_px", f), f, "lcd_px")});
    all.push_back(marks);
  }
  return all;
}

void Dataset::write_alignments(const std::vector<std::vector<Alignment>>& all) const {
  json j;
  for (DisplayId id : kDisplays) {
    json marks = json::array();
    for (const Alignment& a : all.at(index_of(id)))
      marks.push_back({{"p_rsb_mm", wheatstone::to_json(a.p_rsb_mm)},
                       {"lcd_px", wheatstone::to_json(a.lcd_px)}});
    j[to_string(id)] = marks;
  }
  write_json(file("alignments.json"), "wheatstone-alignments/1", j);
}

std::vector<EyeDisplayCalibration> Dataset::read_eyes() const {
  const path f = file("eyes.json");
  const json j = read_json(f, "wheatstone-eyes/1");
  std::vector<EyeDisplayCalibration> eyes;
  for (const json& e : array_of(j, "displays", 4, f)) {
    EyeDisplayCalibration c;
    c.id = display_from_string(json_get<std::string>(e, "id", f));
    if (!(c.id == kDisplays[eyes.size()])) throw_bad_key(f, "id", "is out of order");
    c.P_lcd_rsb = matrix_from_json(json_get<json>(e, "P_lcd_rsb", f), 3, 4, f, "P_lcd_rsb");
    c.intrinsics = intrinsics_from_json(json_get<json>(e, "intrinsics", f), f);
    c.T_eye_rsb.R = matrix_from_json(json_get<json>(e, "R_eye_rsb", f), 3, 3, f, "R_eye_rsb");
    c.T_eye_rsb.t_mm = vector3_from_json(json_get<json>(e, "t_eye_rsb_mm", f), f, "t_eye_rsb_mm");
    c.rms_px = json_get<double>(e, "rms_px", f);
    for (const json& r : array_of(e, "residuals_px", 0, f))
      c.residuals_px.push_back(vector2_from_json(r, f, "residuals_px"));
    eyes.push_back(c);
  }
  return eyes;
}

void Dataset::write_eyes(const std::vector<EyeDisplayCalibration>& eyes) const {
  json list = json::array();
  for (const EyeDisplayCalibration& c : eyes) {
    json residuals = json::array();
    for (const Eigen::Vector2d& r : c.residuals_px) residuals.push_back(wheatstone::to_json(r));
    list.push_back({{"id", to_string(c.id)},
                    {"P_lcd_rsb", wheatstone::to_json(Eigen::MatrixXd(c.P_lcd_rsb))},
                    {"intrinsics", to_json(c.intrinsics)},
                    {"R_eye_rsb", wheatstone::to_json(Eigen::MatrixXd(c.T_eye_rsb.R))},
                    {"t_eye_rsb_mm", wheatstone::to_json(c.T_eye_rsb.t_mm)},
                    {"rms_px", c.rms_px},
                    {"residuals_px", residuals}});
  }
  write_json(file("eyes.json"), "wheatstone-eyes/1", {{"displays", list}});
}

}  // namespace wheatstone
