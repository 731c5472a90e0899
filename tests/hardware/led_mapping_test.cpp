#include "hardware/led_mapping.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "tests/error_text.h"

namespace wheatstone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

LedMapping small(const char* corner, bool along_rows, bool serpentine) {
  return {2, 3, corner, along_rows, serpentine};
}

TEST(LedMapping, BeginsAtItsCornerAndRunsLineByLine) {
  EXPECT_THAT(places_on_wire(small("back-left", true, false)), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(places_on_wire(small("back-left", true, true)), ElementsAre(0, 1, 2, 5, 4, 3));
  EXPECT_THAT(places_on_wire(small("back-right", true, false)), ElementsAre(2, 1, 0, 5, 4, 3));
  EXPECT_THAT(places_on_wire(small("front-left", true, true)), ElementsAre(5, 4, 3, 0, 1, 2));
  EXPECT_THAT(places_on_wire(small("back-left", false, false)), ElementsAre(0, 2, 4, 1, 3, 5));
  EXPECT_THAT(places_on_wire(small("front-right", false, true)), ElementsAre(5, 2, 1, 4, 3, 0));
}

TEST(LedMapping, PassesEveryLedOnce) {
  for (const char* corner : {"back-left", "back-right", "front-left", "front-right"})
    for (const bool along_rows : {false, true})
      for (const bool serpentine : {false, true}) {
        std::vector<int> places = places_on_wire({16, 16, corner, along_rows, serpentine});
        std::sort(places.begin(), places.end());
        std::vector<int> all(256);
        std::iota(all.begin(), all.end(), 0);
        EXPECT_EQ(places, all) << corner;
      }
}

TEST(LedMapping, RefusesWhatIsNone) {
  for (const char* corner : {"", "back", "left", "back-top", "top-left", "back--left"})
    EXPECT_THAT(error_of([&] { places_on_wire(small(corner, true, true)); }),
                HasSubstr("back-left, "))
        << corner;
  for (const int n : {0, -1, 513, std::numeric_limits<int>::max()}) {
    EXPECT_THAT(error_of([&] { places_on_wire({n, 16}); }), HasSubstr("1 to 512"));
    EXPECT_THAT(error_of([&] { places_on_wire({16, n}); }), HasSubstr("1 to 512"));
  }
}

}  // namespace
}  // namespace wheatstone
