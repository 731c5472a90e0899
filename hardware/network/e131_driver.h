#pragma once

#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// Driver "e131" of the rig file.
void add_e131_driver(DriverCatalogue&);

}  // namespace wheatstone
