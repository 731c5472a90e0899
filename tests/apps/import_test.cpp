// Importing what this program wrote, and what `import` says to arguments it cannot use.
#include <gmock/gmock.h>

#include "capture/import/poses_json.h"
#include "core/exr.h"
#include "core/files.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Import : public TemporaryFolder {};

TEST_F(Import, ADatasetComesBackWithTheSameLight) {
  write_small_light_field(root_ / "d");
  const Outcome outcome = run_program({"import", path("d"), "--out", path("again")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("3 posed views"));
  for (const char* view : {"views/view_0.exr", "views/view_2.exr"}) {
    const RgbImage before = read_exr(root_ / "d" / view), after = read_exr(root_ / "again" / view);
    ASSERT_EQ(before.pixels.size(), after.pixels.size());
    EXPECT_EQ(cv::norm(before.pixels, after.pixels, cv::NORM_INF), 0) << view;
  }
  const auto poses = read_poses_json(path("d/views.json")),
             imported = read_poses_json(path("again/views.json"));
  ASSERT_EQ(imported.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(poses[i].T_camera_world.t_mm, imported[i].T_camera_world.t_mm);
  EXPECT_EQ(run_program({"calibrate", "eyes", path("again")}).status, 0);

  // One view alone is as it was, too.
  fs::remove(path("d/views/view_0.exr"));
  fs::remove(path("d/views/view_1.exr"));
  const Outcome one = run_program({"import", path("d/views.json"), "--out", path("one")});
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_THAT(one.out, AllOf(HasSubstr("1 posed view,"), Not(HasSubstr("views"))));
}

TEST_F(Import, AnExrWithoutAScaleTakesTheOneThatIsGiven) {
  fs::create_directories(root_ / "d");
  // Y alone has no whiteLuminance, and neither have named channels.
  write_exr_rows(root_ / "d/a.exr", {{8, 6}, {{"R"}, {"G"}, {"B"}}},
                 [](cv::Range, std::span<cv::Mat1f> bands) {
                   for (cv::Mat1f& band : bands) band = 0.5f;
                 });
  ImportedView view{"a", root_ / "d/a.exr", {9, 9, 0, 3.5, 2.5, 8, 6}, {}, {}};
  write_poses_json(root_ / "d/poses.json", std::vector<ImportedView>{view});
  const Outcome outcome =
      run_program({"import", path("d"), "--white-cd-m2", "300", "--out", path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_exr(root_ / "out/views/a.exr").pixels(3, 3), cv::Vec3f(150, 150, 150));
}

TEST_F(Import, APictureWithoutPoseIsToldWhatItLacks) {
  write_exr(path("rendered.exr"), RgbImage(8, 6));
  expect_refused(run_program({"import", path("rendered.exr"), "--out", path("out")}),
                 {path("rendered.exr"), "without pose or depth", "poses.json", "left and right"});
  write_small_light_field(root_ / "d");
  fs::remove(path("d/views.json"));
  expect_refused(run_program({"import", path("d"), "--out", path("out")}),
                 {path("d"), "capture without poses", "wheatstone calibrate poses"});
  EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(Import, OptionsOutOfRangeAreNamedWithTheirRange) {
  write_exr(path("rendered.exr"), RgbImage(8, 6));
  const auto refused = [&](const std::string& option, const std::string& value,
                           const std::vector<std::string>& parts) {
    expect_refused(
        run_program({"import", path("rendered.exr"), option, value, "--out", path("out")}), parts);
  };
  for (const char* value : {"200", "170", "0", "-5", "nan"})
    refused("--hfov-deg", value,
            {std::string("--hfov-deg is ") + value, "0 to 170 degrees", "width of the stereo"});
  for (const char* value : {"0", "-1", "nan", "inf"})
    refused("--white-cd-m2", value, {std::string("--white-cd-m2 is ") + value, "above 0"});
  for (const char* value : {"-1", "nan", "inf"})
    refused("--mm-per-unit", value, {std::string("--mm-per-unit is ") + value, "0 chooses it"});
  EXPECT_FALSE(fs::exists(path("out")));
}

}  // namespace
}  // namespace wheatstone::apps
