// `merge` as a cluster drives it: in shards, killed, and run again.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <map>

#include "apps/stations.h"
#include "capture/session.h"
#include "core/files.h"
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
