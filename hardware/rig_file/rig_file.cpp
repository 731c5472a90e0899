#include "hardware/rig_file/rig_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/dataset.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr const char* kSchema = "wheatstone-rig/1";
constexpr const char* kManual = "docs/rig_file.md";
constexpr double kLongestMm = 10'000;

std::vector<Eigen::Vector3d> points(const TomlTable& table, const std::string& key) {
  std::vector<Eigen::Vector3d> out;
  for (const auto& p : table.points(key)) {
    out.emplace_back(p[0], p[1], p[2]);
    if (out.back().cwiseAbs().maxCoeff() > kLongestMm)
      table.fail(key, "has a point further than 10 m from the box", "give mm in the box's frame");
  }
  return out;
}

WantedOutput read_output(const TomlTable& table) {
  WantedOutput out;
  out.role = table.text("role");
  out.edid.manufacturer = table.text_or("manufacturer", "");
  out.edid.product = static_cast<std::uint16_t>(table.integer_or("product", 0, 0, 65535));
  out.edid.serial = static_cast<std::uint32_t>(table.integer_or("serial", 0, 0, 4294967295));
  out.edid.name = table.text_or("name", "");
  out.edid.serial_text = table.text_or("serial_text", "");
  out.connector = table.text_or("connector", "");
  if (out.edid == EdidIdentity{} && out.connector.empty())
    table.fail("role", "has a display that nothing identifies",
               "give manufacturer, product and serial of its EDID, or its connector");
  out.width_px = static_cast<int>(table.integer("width_px", 1, 100'000));
  out.height_px = static_cast<int>(table.integer("height_px", 1, 100'000));
  out.refresh_hz = table.number_or("refresh_hz", 0, 1, 1000);
  out.bits_per_channel = static_cast<int>(table.integer_or("bits_per_channel", 8, 6, 16));
  table.finish();
  return out;
}

/// Two devices at one address would talk over each other; parts of one controller do not.
class Addresses {
 public:
  template <class D>
  void add(const TomlTable& table, const std::string& role, const DevicePlan<D>& plan) {
    if (plan.address.empty()) return;
    for (const auto& [part, other] : taken_[plan.address])
      if (part.empty() || plan.part.empty() || part == plan.part)
        table.fail("driver",
                   fmt::format("has its device at {}, where the {} is", plan.address, other),
                   "give each device its own address");
    taken_[plan.address].emplace_back(plan.part, role);
  }

 private:
  std::map<std::string, std::vector<std::pair<std::string, std::string>>> taken_;
};

}  // namespace

RigDescription read_rig_file(const std::filesystem::path& file, const DriverCatalogue& catalogue) {
  const TomlTable top = TomlTable::read(file, kManual);
  if (top.text("schema") != kSchema) top.fail("schema", std::string("is not \"") + kSchema + "\"");
  RigDescription rig;
  rig.file = file;
  rig.name = top.text("name");
  Addresses addresses;
  const auto read = [&](const char* role, auto& plan) {
    if (!top.has(role)) return;
    const TomlTable table = top.table(role);
    plan = catalogue.read<typename std::decay_t<decltype(*plan)>::Device>(table);
    addresses.add(table, role, *plan);
  };
  read("stage", rig.stage);
  read("platform", rig.platform);
  read("markers", rig.markers);
  read("leds", rig.leds);
  read("camera", rig.camera);
  read("video", rig.video);
  read("spectroradiometer", rig.spectroradiometer);
  read("head_tracker", rig.head_tracker);
  read("light_sensor", rig.light_sensor);
  read("display_outputs", rig.display_outputs);
  for (const TomlTable& output : top.tables("output")) rig.outputs.push_back(read_output(output));
  std::set<std::string> roles;
  for (const WantedOutput& output : rig.outputs)
    if (!roles.insert(output.role).second)
      top.fail("output", "has two displays with the role " + output.role, "give each its own role");

  if (top.has("geometry")) {
    const TomlTable geometry = top.table("geometry");
    if (geometry.has("markers_rsb_mm"))
      rig.marker_positions_rsb_mm = points(geometry, "markers_rsb_mm");
    if (geometry.has("near_crosses_rsb_mm"))
      rig.near_cross_positions_rsb_mm = points(geometry, "near_crosses_rsb_mm");
    geometry.finish();
  }
  if (top.has("calibration")) {
    const TomlTable calibration = top.table("calibration");
    if (calibration.has("camera")) rig.camera_profile = calibration.file("camera");
    if (calibration.has("displays")) rig.displays = calibration.file("displays");
    calibration.finish();
  }
  const TomlTable safety = top.table("safety");
  rig.luminance_limit = Luminance::of(safety.number("luminance_limit_cd_m2", 0.01, 1e5));
  rig.watchdog = Duration::of(safety.number_or("watchdog_s", 120, 1, 3600));
  safety.finish();
  if (top.has("soft_limits")) {
    const TomlTable limits = top.table("soft_limits");
    const auto pair = [&](const char* key, double largest) {
      const auto ends = limits.numbers<2>(key, 0, largest);
      if (ends[0] >= ends[1])
        limits.fail(key, "has its limits inverted", "give the smaller one first");
      return ends;
    };
    if (limits.has("stage_mm")) {
      const auto ends = pair("stage_mm", kLongestMm);
      rig.soft_stage = {Length::of(ends[0]), Length::of(ends[1])};
    }
    if (limits.has("platform_deg")) {
      const auto ends = pair("platform_deg", 360);
      rig.soft_platform = {degrees(ends[0]), degrees(ends[1])};
    }
    limits.finish();
  }
  if (top.has("simulation")) {
    const TomlTable simulation = top.table("simulation");
    rig.simulation.scene = simulation.text_or("scene", rig.simulation.scene);
    rig.simulation.scale = simulation.number_or("scale", rig.simulation.scale, 1e-3, 1);
    rig.simulation.seed =
        static_cast<std::uint64_t>(simulation.integer_or("seed", 7, 0, INT64_MAX));
    simulation.finish();
  }
  top.finish();

  const auto devices = rig.devices();
  const auto simulated = std::count_if(devices.begin(), devices.end(), [](const auto& device) {
    return device.driver == kSimulatedDriver;
  });
  if (simulated != 0 && simulated != std::ssize(devices))
    throw FileError(file, "mixes simulated and real devices, which have no clock in common",
                    "make all of them simulated, or none");
  if (rig.camera && simulated == 0 && !rig.camera_profile)
    throw FileError(file, "has a still camera without its calibration",
                    "add [calibration] with camera = \"camera.json\"");
  if (rig.markers && simulated == 0 && rig.marker_positions_rsb_mm.empty())
    throw FileError(file, "has marker lights but does not say where they are",
                    "add [geometry] with markers_rsb_mm");
  return rig;
}

bool RigDescription::simulated() const {
  const auto all = devices();
  return !all.empty() && all.front().driver == kSimulatedDriver;
}

std::vector<RigDescription::Line> RigDescription::devices() const {
  std::vector<Line> out;
  for_each_kind([&](const char* role, const auto& plan) {
    if (plan) out.push_back({role, plan->driver, plan->address});
  });
  return out;
}

OpenRig::OpenRig(const RigDescription& description, Clock& clock, RigContext context)
    : clock_(clock), description_(description), context_(std::move(context)) {
  const auto open = [&](const auto& plan, auto& device) {
    if (plan) device = plan->open(context_);
  };
  open(description.stage, stage_);
  open(description.platform, platform_);
  open(description.markers, markers_);
  open(description.leds, leds_);
  open(description.camera, camera_);
  open(description.video, video_);
  open(description.spectroradiometer, spectroradiometer_);
  open(description.head_tracker, head_tracker_);
  open(description.light_sensor, light_sensor_);
  open(description.display_outputs, display_outputs_);
}

Rig OpenRig::rig() {
  Rig rig(clock_);
  rig.luminance_limit = description_.luminance_limit;
  if (stage_) rig.stage = *stage_;
  if (platform_) rig.platform = *platform_;
  if (markers_) rig.markers = *markers_;
  if (leds_) rig.leds = *leds_;
  if (camera_) rig.camera = *camera_;
  if (video_) rig.video = *video_;
  if (spectroradiometer_) rig.spectroradiometer = *spectroradiometer_;
  if (head_tracker_) rig.head_tracker = *head_tracker_;
  if (light_sensor_) rig.light_sensor = *light_sensor_;
  if (description_.camera_profile)
    rig.camera_profile = read_camera_profile(*description_.camera_profile);
  if (description_.displays) rig.panel_models = read_panel_models(*description_.displays);
  rig.marker_positions_rsb_mm = description_.marker_positions_rsb_mm;
  rig.near_cross_positions_rsb_mm = description_.near_cross_positions_rsb_mm;
  return rig;
}

}  // namespace wheatstone
