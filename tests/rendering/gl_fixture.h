#pragma once
// Tests that need OpenGL, software or hardware; skipped where there is none.

#include <gtest/gtest.h>

#include <memory>

#include "core/error.h"
#include "rendering/gl/offscreen.h"

namespace wheatstone::testing {

class GlFixture : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<OffscreenContext>();
    } catch (const GraphicsError& e) {
      GTEST_SKIP() << e.what();
    }
  }
  std::unique_ptr<OffscreenContext> context_;
};

}  // namespace wheatstone::testing
