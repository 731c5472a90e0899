#pragma once

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Driver "gphoto2" of the rig file.
void add_gphoto_driver(DriverCatalogue&);

}  // namespace wheatstone
