// A million texts that no camera writes.

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "core/random.h"
#include "hardware/still/exposure_text.h"

namespace wheatstone {
namespace {

TEST(ExposureTextFuzz, AnyTextIsATimeOrNone) {
  constexpr int kTexts = 1'000'000;
  const std::array<std::string, 6> valid = {"1/250", "30", "0.5", "13/10", "Bulb", "1/8000s"};
  RandomStream random(11, 0);
  int times = 0;
  for (int i = 0; i < kTexts; ++i) {
    std::string text = valid[random.next() % valid.size()];
    const std::size_t changes = random.next() % 4;
    for (std::size_t k = 0; k < changes; ++k) {
      const std::size_t at = random.next() % (text.size() + 1);
      const char c = random.next() % 2 ? static_cast<char>(random.next())
                                       : "0123456789/.es\""[random.next() % 15];
      if (random.next() % 2 || at == text.size())
        text.insert(at, 1 + random.next() % 40, c);
      else
        text[at] = c;
    }
    const auto seconds = exposure_seconds(text);
    if (!seconds) continue;
    ++times;
    ASSERT_TRUE(*seconds > 0 && *seconds < 1e5) << text;
  }
  EXPECT_GT(times, 100'000);
  EXPECT_LT(times, 900'000);
}

}  // namespace
}  // namespace wheatstone
