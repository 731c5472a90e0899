#include "hardware/device_error.h"

#include <gtest/gtest.h>

namespace wheatstone {
namespace {

TEST(DeviceError, KeepsItsKindAndSaysTheRemedy) {
  const DeviceError e(DeviceError::Kind::kNotReady, "the stage is lost", "home it first");
  EXPECT_EQ(e.kind(), DeviceError::Kind::kNotReady);
  EXPECT_STREQ(e.what(), "the stage is lost; home it first");
  EXPECT_EQ(to_string(e.kind()), "not ready");
}

}  // namespace
}  // namespace wheatstone
