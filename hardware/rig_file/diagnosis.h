#pragma once

#include <string>
#include <vector>

#include "hardware/rig_file/rig_file.h"

namespace wheatstone {

/// How one device of the rig file answers.
struct DeviceDiagnosis {
  std::string role, driver, address;
  std::string status;  // "ok", or the kind of the error: "not found", "busy", "permission", ...
  DeviceIdentity identity;  // where it is ok
  std::string problem;      // with the remedy; empty where it is ok
};

/// Opens every device by itself and closes it again; nothing moves and nothing is lit.
std::vector<DeviceDiagnosis> diagnose(const RigDescription&);

}  // namespace wheatstone
