#pragma once
// The drivers that this program was built with, and what of theirs is plugged in.

#include <string>
#include <vector>

#include "hardware/rig_file/diagnosis.h"
#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone::apps {

DriverCatalogue all_drivers();

/// A device that is plugged in and that no device of the rig file is.
struct OtherDevice {
  std::string what;     // "serial line", "marker light", ...
  std::string address;  // for people, with what the rig file calls it
  std::string problem;  // with the remedy; empty: it can be used
};
/// Looks for devices of every driver that can list them. `found`: as diagnose() says.
std::vector<OtherDevice> other_devices(const RigDescription&,
                                       const std::vector<DeviceDiagnosis>& found);

}  // namespace wheatstone::apps
