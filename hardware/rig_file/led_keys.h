#pragma once

#include "core/toml_file.h"
#include "hardware/led_mapping.h"

namespace wheatstone {

/// Keys "rows", "columns", "corner", "lines" and "serpentine" of an LED array's table.
LedMapping read_led_mapping(const TomlTable&);

}  // namespace wheatstone
