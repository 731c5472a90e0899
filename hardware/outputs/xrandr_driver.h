#pragma once

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Driver "xrandr" of the rig file.
void add_xrandr_driver(DriverCatalogue&);

}  // namespace wheatstone
