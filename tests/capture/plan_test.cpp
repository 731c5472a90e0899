#include "capture/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "core/error.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CapturePlanTest, EveryFrameOnceFromOneEndToTheOtherAndBack) {
  const CapturePlan plan{3, {0.01, 0.1}, 0.02};
  const std::vector<Shot> shots = shots_of(plan, Length::of(100));
  ASSERT_EQ(shots.size(), 10U);
  std::set<std::string> files;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const Shot& s = shots[i];
    files.insert(s.file);
    const bool last = i == 9;
    EXPECT_EQ(s.view, last ? kReturnView : "view_00" + std::to_string(i / 3));
    EXPECT_EQ(s.position.value(), last ? 0 : 50.0 * static_cast<double>(i / 3));
    EXPECT_EQ(s.approach, last ? Shot::Approach::kFromAbove : Shot::Approach::kFromBelow);
    const bool markers = last || i % 3 == 2;
    EXPECT_EQ(s.light, markers ? Shot::Light::kMarkers : Shot::Light::kCeiling);
    EXPECT_EQ(s.exposure_s, markers ? 0.02 : plan.exposures_s[i % 3]);
  }
  EXPECT_EQ(files.size(), shots.size()) << "no two frames share a file";
}

TEST(CapturePlanTest, OneViewAndOneExposureStandInTheMiddleAndDoNotReturn) {
  const std::vector<Shot> shots = shots_of({1, {0.01}}, Length::of(100));
  ASSERT_EQ(shots.size(), 2U);
  EXPECT_EQ(shots[0].position.value(), 50);
  EXPECT_EQ(shots[1].light, Shot::Light::kMarkers);
}

TEST(CapturePlanTest, RefusesWhatCannotBeCarriedOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate({}), "");
  EXPECT_EQ(validate({1, {0.01}}), "");
  EXPECT_THAT(validate({0}), HasSubstr("view"));
  EXPECT_THAT(validate({1000}), HasSubstr("999"));
  EXPECT_THAT(validate({1, {}}), HasSubstr("exposure"));
  EXPECT_THAT(validate({1, {0.01, 0.01}}), HasSubstr("twice"));
  for (const double t : {0.0, -1.0, nan}) {
    EXPECT_THAT(validate({1, {t}}), HasSubstr("above 0"));
    EXPECT_THAT(validate({1, {0.01}, t}), HasSubstr("marker"));
  }
  EXPECT_THAT(validate({1, {0.01}, 0.01, -0.1}), HasSubstr("rest"));
}

TEST(CapturePlanTest, SurvivesItsJournal) {
  const CapturePlan plan{7, {1.0 / 3, 0.1}, 0.02, 0.25, 50, 0.9};
  const nlohmann::json there = nlohmann::json::parse(to_json(plan).dump());
  EXPECT_EQ(to_json(plan_from_json(there, "journal")), to_json(plan));
  nlohmann::json damaged = there;
  damaged["exposures_s"] = "long";
  EXPECT_THAT(error_of([&] { plan_from_json(damaged, "journal"); }), HasSubstr("exposures_s"));
  damaged.erase("exposures_s");
  EXPECT_THAT(error_of([&] { plan_from_json(damaged, "journal"); }), HasSubstr("journal"));
}

TEST(CapturePlanTest, NamesEveryDifference) {
  const CapturePlan there{11}, asked{5, {1 / 240.0, 1 / 60.0}};
  const std::string lines = difference({{"plan", to_json(there)}}, {{"plan", to_json(asked)}});
  EXPECT_THAT(lines, HasSubstr("plan/views: 11 there, 5 asked for"));
  EXPECT_THAT(lines, HasSubstr("plan/exposures_s/2"));
  EXPECT_THAT(lines, HasSubstr("nothing asked for"));
  EXPECT_THAT(lines, ::testing::Not(HasSubstr("marker")));
  EXPECT_EQ(difference(to_json(there), to_json(there)), "");
}

}  // namespace
}  // namespace wheatstone
