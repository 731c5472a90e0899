#pragma once
// The metrics' reference vectors in tests/vectors/metrics.

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "core/image.h"

namespace wheatstone {

inline const std::string kMetricVectors =
    std::string(WHEATSTONE_SOURCE_DIR) + "/tests/vectors/metrics/";

inline nlohmann::json read_vectors(const std::string& name) {
  std::ifstream in(kMetricVectors + name);
  return nlohmann::json::parse(in);
}

/// Little-endian colour PFM, bottom row first.
inline RgbImage read_pfm(const std::string& name) {
  std::ifstream in(kMetricVectors + name, std::ios::binary);
  std::string magic;
  int width = 0, height = 0;
  double scale = 0;
  in >> magic >> width >> height >> scale;
  in.get();
  if (magic != "PF" || scale >= 0) throw std::runtime_error("unexpected PFM " + name);
  RgbImage image(width, height);
  for (int r = height - 1; r >= 0; --r)
    in.read(reinterpret_cast<char*>(image.pixels.ptr(r)), width * std::streamsize{12});
  if (!in) throw std::runtime_error("short PFM " + name);
  return image;
}

}  // namespace wheatstone
