#pragma once
// Camera noise profiles as files (profiles/*.toml, docs/hdr_merge.md).

#include <filesystem>
#include <string>

#include "core/rig_types.h"

namespace wheatstone {

struct NoiseProfile {
  std::string camera;
  int bits = 14;
  SensorNoise noise;
  std::string source;  // who measured it and how, for people
};

/// Errors: FileError naming the file and the key or line: missing, not TOML, another schema,
/// unknown keys, parameters that are no noise.
NoiseProfile read_noise_profile(const std::filesystem::path&);
/// Atomic; numbers read back exactly. Errors: FileError.
void write_noise_profile(const std::filesystem::path&, const NoiseProfile&);

}  // namespace wheatstone
