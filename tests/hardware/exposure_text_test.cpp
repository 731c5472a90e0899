#include "hardware/still/exposure_text.h"

#include <gtest/gtest.h>

namespace wheatstone {
namespace {

TEST(ExposureText, IsReadAsCamerasWriteIt) {
  EXPECT_EQ(exposure_seconds("1/250"), 1.0 / 250);
  EXPECT_EQ(exposure_seconds("30"), 30);
  EXPECT_EQ(exposure_seconds("0.5"), 0.5);
  EXPECT_EQ(exposure_seconds("13/10"), 13.0 / 10);
  EXPECT_EQ(exposure_seconds("1.3\""), 1.3);
  EXPECT_EQ(exposure_seconds("0.0333s"), 0.0333);
}

TEST(ExposureText, OtherTextsAreNone) {
  for (const char* text : {"",     "Bulb",  "Auto",      "1/",    "/60",  "1/0",   "0",
                           "-1",   "-1/60", "1/60/2",    "1 /60", "nan",  "inf",   "1/nan",
                           "1e3x", "1/60 ", "999999999", "\xff",  "0x10", "1/-60", "s"})
    EXPECT_FALSE(exposure_seconds(text)) << text;
}

}  // namespace
}  // namespace wheatstone
