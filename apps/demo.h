#pragma once
// The whole way in one command, with a report.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/stations.h"

namespace wheatstone::apps {

struct DemoOptions {
  std::filesystem::path out = "out/demo";
  std::optional<std::filesystem::path> real_data;  // a folder like ../shared/data
  std::vector<std::string> scenes = {"card", "sphere", "objects"};
  double scale = 0.25;
  std::uint64_t seed = 7;
  double fault_probability = 0;  // of every call of a device
};

/// Writes <out>/<scene>/ (datasets), report.html and summary.json ("wheatstone-summary/1").
void run_demo(const DemoOptions&, const Progress&);

}  // namespace wheatstone::apps
