#pragma once

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Driver "v4l2" of the rig file.
void add_v4l2_driver(DriverCatalogue&);

}  // namespace wheatstone
