// `merge` as a cluster drives it: in shards, killed, and run again.
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>

#include "apps/stations.h"
#include "capture/session.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "program.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;

class MergeShard : public TemporaryFolder {
 protected:
  static constexpr int kViews = 5;

  void capture(const std::string& name) {
    SimulatedRig twin({"card", 0.05, 7});
    const Dataset dataset(root_ / name);
    make_folder(dataset.root());
    CapturePlan plan;
    plan.views = kViews;
    capture_light_field(twin.rig(), dataset, {"capture", "card", 7, 0.05, "simulated rig", 0, 1},
                        plan, {});
  }
  void copy(const std::string& from, const std::string& to) {
    fs::copy(path(from), path(to), fs::copy_options::recursive);
  }
  int run(const std::string& dataset, std::vector<std::string> more = {},
          const Surroundings& around = {}) {
    more.insert(more.begin(), {"merge", path(dataset)});
    return run_program(more, around).status;
  }
  /// Finished views and their bytes; what a killed run left aside is no view.
  std::map<std::string, std::vector<std::byte>> views(const std::string& dataset) {
    std::map<std::string, std::vector<std::byte>> out;
    if (!fs::exists(path(dataset + "/hdr"))) return out;
    for (const CapturedView& view : Dataset(path(dataset)).read_frames()) {
      const fs::path file = path(dataset + "/hdr/" + view.name + ".exr");
      if (fs::exists(file)) out[view.name] = read_bytes(file);
    }
    return out;
  }
};

TEST_F(MergeShard, LampsThatDriftAreBroughtBack) {
  capture("steady");
  // A piece of the back wall above the card, as each view shows it.
  std::string csv = "view,x_px,y_px,width_px,height_px\n";
  const Dataset steady(root_ / "steady");
  const CameraProfile camera = steady.read_camera();
  for (const CapturedView& view : steady.read_frames())
    csv += view.name + "," + std::to_string(camera.intrinsics.width_px / 2 - 20) + ",6,40,16\n";
  write_text_atomically(root_ / "patches.csv", csv);

  // In the third view the lamps are a tenth darker.
  copy("steady", "drifting");
  const CapturedView dim = steady.read_frames()[2];
  for (const ExposureRecord& e : dim.exposures) {
    MosaicImage frame = read_mosaic_png(root_ / "drifting" / e.file, camera.pattern);
    for (std::uint16_t& dn : frame.dn)
      if (dn < camera.white_dn)
        dn = static_cast<std::uint16_t>(
            std::lround(camera.black_dn + 0.9 * (static_cast<double>(dn) - camera.black_dn)));
    write_mosaic_png(root_ / "drifting" / e.file, frame);
  }
  const std::vector<std::string> patches = {"--monitor-patch", path("patches.csv")};
  copy("drifting", "uncorrected");
  copy("drifting", "sharded");
  ASSERT_EQ(run("steady", patches), 0);
  ASSERT_EQ(run("drifting", patches), 0);
  const auto mean = [&](const std::string& dataset, const std::string& view) {
    const cv::Scalar m = cv::mean(read_exr(root_ / dataset / "hdr" / (view + ".exr")).pixels);
    return m[0] + m[1] + m[2];
  };
  EXPECT_NEAR(mean("drifting", dim.name) / mean("steady", dim.name), 1, 0.005);
  EXPECT_NEAR(
      read_json(root_ / "drifting/hdr" / (dim.name + "_lamp.json"))["factor"].get<double>() /
          read_json(root_ / "steady/hdr" / (dim.name + "_lamp.json"))["factor"].get<double>(),
      1 / 0.9, 0.005);
  EXPECT_EQ(read_json(root_ / "drifting/hdr/view_000_lamp.json")["factor"], 1.0);

  for (const char* shard : {"3/3", "2/3", "1/3"}) {
    std::vector<std::string> more = patches;
    more.insert(more.end(), {"--shard", shard});
    ASSERT_EQ(run("sharded", more), 0);
  }
  EXPECT_TRUE(views("sharded") == views("drifting"));

  // One folder, one choice.
  ASSERT_EQ(run("uncorrected"), 0);
  expect_refused(run_program({"merge", path("uncorrected"), patches[0], patches[1]}),
                 {"without the lamps' drift", "remove the folder hdr"});
  expect_refused(run_program({"merge", path("drifting")}), {"with the lamps' drift"});
  fs::remove_all(root_ / "drifting/hdr");
  write_text_atomically(root_ / "patches.csv", csv.substr(0, csv.find("view_003")));
  expect_refused(run_program({"merge", path("drifting"), patches[0], patches[1]}),
                 {"no monitor patch for view_003"});
  write_text_atomically(root_ / "patches.csv", csv + "view_000,1,1,4,4\n");
  expect_refused(run_program({"merge", path("drifting"), patches[0], patches[1]}),
                 {"patches.csv:7", "second patch for view_000"});
}

TEST_F(MergeShard, SerialShardedAndKilledRunsGiveTheSameBytes) {
  capture("serial");
  copy("serial", "sharded");
  copy("serial", "killed");
  ASSERT_EQ(run("serial"), 0);
  const auto serial = views("serial");
  ASSERT_EQ(serial.size(), std::size_t{kViews});

  ASSERT_EQ(run("sharded", {"--shard", "2/2"}), 0);
  EXPECT_EQ(views("sharded").size(), 2u);
  ASSERT_EQ(run("sharded", {"--shard", "1/2"}), 0);
  EXPECT_TRUE(views("sharded") == serial);
  expect_nothing_half_written(root_);

  // Killed as soon as one more view is there, that is while the next one is in work.
  std::size_t finished = 0;
  int killed = 0;
  while (finished < std::size_t{kViews}) {
    const auto one_more = [&] { return views("killed").size() > finished; };
    killed += run("killed", {}, {{}, {}, one_more}) == 128 + SIGKILL;
    const auto now = views("killed");
    ASSERT_GT(now.size(), finished);
    for (const auto& [name, bytes] : now) EXPECT_TRUE(bytes == serial.at(name)) << name;
    finished = now.size();
  }
  EXPECT_GE(killed, 1);
  ASSERT_EQ(run("killed"), 0);
  EXPECT_TRUE(views("killed") == serial);
}

TEST_F(MergeShard, AFinishedViewIsNotMergedAgain) {
  capture("d");
  ASSERT_EQ(run("d"), 0);
  const auto before = views("d");
  fs::remove_all(path("d/raw"));
  EXPECT_EQ(run("d"), 0);
  EXPECT_TRUE(views("d") == before);
}

TEST_F(MergeShard, BadShardsAreRefused) {
  capture("d");
  for (const char* shard : {"0/2", "3/2", "2", "1/0", "-1/2", "a/b", "1/2/3"})
    expect_refused(run_program({"merge", path("d"), "--shard", shard}), {shard, "i/N"});
  EXPECT_FALSE(fs::exists(path("d/hdr")));
  EXPECT_NE(
      run_program({"merge", "--frames", path("f.json"), "--out", path("o.exr"), "--shard", "1/2"})
          .status,
      0);
}

}  // namespace
}  // namespace wheatstone::apps
