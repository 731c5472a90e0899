#pragma once

#include <string>

#include "core/csv.h"

namespace wheatstone {

inline CsvTable read_vectors(const std::string& name) {
  return CsvTable::read(std::string(WHEATSTONE_SOURCE_DIR) + "/tests/vectors/motion_quality/" +
                        name);
}

}  // namespace wheatstone
