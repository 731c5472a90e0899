#pragma once

#include <string>
#include <vector>

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Drivers "hid-relay" and "blink1" of the rig file.
void add_hid_drivers(DriverCatalogue&);

/// A marker light that is plugged in.
struct HidLightFound {
  std::string address;  // as plans of the rig file have it; empty: it could not be asked
  std::string node;
  std::string problem;  // with the remedy; empty: it can be used
};
std::vector<HidLightFound> list_hid_lights();

}  // namespace wheatstone
