#pragma once
// The metrics' reference vectors in tests/vectors/metrics.

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/hdr_files.h"

namespace wheatstone {

inline const std::string kMetricVectors =
    std::string(WHEATSTONE_SOURCE_DIR) + "/tests/vectors/metrics/";

inline nlohmann::json read_vectors(const std::string& name) {
  std::ifstream in(kMetricVectors + name);
  return nlohmann::json::parse(in);
}

inline RgbImage vector_image(const std::string& name) {
  return read_pfm(kMetricVectors + name);
}

}  // namespace wheatstone
