#pragma once

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Driver "fadecandy" of the rig file.
void add_fadecandy_driver(DriverCatalogue&);

}  // namespace wheatstone
