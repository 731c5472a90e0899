#pragma once
// Which drivers there are, and how each reads its table of the rig file.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/toml_file.h"
#include "hardware/display_outputs.h"
#include "hardware/head_tracker.h"
#include "hardware/led_array.h"
#include "hardware/light_sensor.h"
#include "hardware/marker_lights.h"
#include "hardware/spectroradiometer.h"
#include "hardware/stage.h"
#include "hardware/still_camera.h"
#include "hardware/transport/transcript.h"
#include "hardware/video_camera.h"

namespace wheatstone {

/// Plans of this driver have nothing to open: the twin's devices belong to its world.
inline constexpr const char* kSimulatedDriver = "simulated";

/// What drivers share while a rig is opened.
struct RigContext {
  Deadline deadline;
  std::shared_ptr<Transcript> transcript;               // null: none
  std::map<std::string, std::shared_ptr<void>> shared;  // by address: what two devices hang on
};

/// One device as the rig file describes it; nothing has been opened yet.
template <class D>
struct DevicePlan {
  using Device = D;
  std::string driver;
  std::string address;  // two devices may not have the same one, but for parts of one controller
  std::string part;     // of a controller that several devices share ("X"); empty: all of it
  std::function<std::unique_ptr<D>(RigContext&)> open;
};

/// Drivers by kind of device and name. Modules add theirs; a driver whose library was missing when
/// the program was built is not there, and the rig file that names it is told so.
class DriverCatalogue {
 public:
  template <class D>
  using Reader = std::function<DevicePlan<D>(const TomlTable&)>;

  /// `read` takes the driver's own keys from the table and throws FileError for what is wrong.
  template <class D>
  void add(const std::string& driver, Reader<D> read) {
    std::get<Readers<D>>(readers_)[driver] = std::move(read);
  }
  /// A driver that this program could have.
  void add_missing(const std::string& driver, const std::string& library) {
    missing_[driver] = library;
  }

  /// Reads key "driver" and then that driver's keys; refuses all others.
  template <class D>
  DevicePlan<D> read(const TomlTable& table) const {
    const std::string driver = table.text("driver");
    const Readers<D>& readers = std::get<Readers<D>>(readers_);
    const auto it = readers.find(driver);
    if (it == readers.end()) refuse(table, driver, names(readers));
    DevicePlan<D> plan = it->second(table);
    table.finish();
    plan.driver = driver;
    return plan;
  }

 private:
  template <class D>
  using Readers = std::map<std::string, Reader<D>>;

  template <class D>
  static std::vector<std::string> names(const Readers<D>& readers) {
    std::vector<std::string> out;
    for (const auto& [name, reader] : readers) out.push_back(name);
    return out;
  }
  [[noreturn]] void refuse(const TomlTable&, const std::string& driver,
                           const std::vector<std::string>& known) const;

  std::tuple<Readers<LinearStage>, Readers<RotaryStage>, Readers<MarkerLights>, Readers<LedArray>,
             Readers<StillCamera>, Readers<VideoCamera>, Readers<Spectroradiometer>,
             Readers<HeadTracker>, Readers<LightSensor>, Readers<DisplayOutputs>>
      readers_;
  std::map<std::string, std::string> missing_;
};

/// For every kind of device that has a twin. Takes no keys.
void add_simulated_drivers(DriverCatalogue&);
/// GRBL and the Arduino gantry.
void add_serial_drivers(DriverCatalogue&);
/// Head trackers and the photodiode.
void add_stream_drivers(DriverCatalogue&);
/// Spectroradiometers.
void add_meter_drivers(DriverCatalogue&);

}  // namespace wheatstone
