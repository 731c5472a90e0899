#pragma once
// Where the real data lie. A test without them is skipped, but fails in CI.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

inline std::filesystem::path shared_folder(const std::string& below) {
  const char* set = std::getenv("WHEATSTONE_SHARED");
  return std::filesystem::path(set ? set : WHEATSTONE_DEFAULT_SHARED) / below;
}

#define REQUIRE_SHARED(path)                                                  \
  if (!std::filesystem::exists(path)) {                                       \
    const char* ci = std::getenv("CI");                                       \
    if (ci && std::string(ci) == "true") FAIL() << (path) << " is not there"; \
    GTEST_SKIP() << (path) << " is not there";                                \
  }
