#include "core/text.h"

#include <gtest/gtest.h>

namespace wheatstone {
namespace {

TEST(Text, OneIsSingular) {
  EXPECT_EQ(counted(1, "view"), "1 view");
  EXPECT_EQ(counted(0, "view"), "0 views");
  EXPECT_EQ(counted(std::size_t{12}, "posed picture"), "12 posed pictures");
}

}  // namespace
}  // namespace wheatstone
