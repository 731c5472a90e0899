// `merge` as a cluster drives it: in shards, killed, and run again.
#include <gmock/gmock.h>

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
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

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
  std::map<std::string, std::string> records(const std::string& dataset) {
    std::map<std::string, std::string> out;
    for (const auto& [view, bytes] : views(dataset))
      out[view] = read_text(path(dataset + "/hdr/" + view + ".json"));
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
  fs::remove_all(root_ / "drifting/session");  // whose journal knows the frames as they were
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
  const auto lamp = [&](const std::string& dataset, const std::string& view) {
    return read_json(root_ / dataset / "hdr" / (view + ".json"))["lamp"];
  };
  EXPECT_NEAR(lamp("drifting", dim.name)["factor"].get<double>() /
                  lamp("steady", dim.name)["factor"].get<double>(),
              1 / 0.9, 0.005);
  EXPECT_EQ(lamp("drifting", "view_000")["factor"], 1.0);
  EXPECT_EQ(lamp("drifting", dim.name)["reference_view"], "view_000");

  for (const char* shard : {"3/3", "2/3", "1/3"}) {
    std::vector<std::string> more = patches;
    more.insert(more.end(), {"--shard", shard});
    ASSERT_EQ(run("sharded", more), 0);
  }
  EXPECT_TRUE(views("sharded") == views("drifting"));

  EXPECT_TRUE(records("sharded") == records("drifting"));

  // Another choice, or another patch, is another light.
  const auto merged = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"merge", path("drifting")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome;
  };
  EXPECT_THAT(merged(patches).out, HasSubstr("0 of 5 views merged"));
  const auto corrected = views("drifting");
  const Outcome plain = merged({});
  EXPECT_THAT(plain.out, HasSubstr("5 of 5 views merged"));
  EXPECT_THAT(plain.err, AllOf(HasSubstr("view_003.exr: merged again"), HasSubstr("patches")));
  ASSERT_EQ(run("uncorrected"), 0);
  EXPECT_TRUE(views("drifting") == views("uncorrected"));
  EXPECT_TRUE(lamp("drifting", dim.name).is_null());
  EXPECT_THAT(merged(patches).out, HasSubstr("5 of 5 views merged"));
  EXPECT_TRUE(views("drifting") == corrected);
  const std::size_t line = csv.find("view_003"), end = csv.find('\n', line);
  const std::string moved = csv.substr(0, end - 2) + "15" + csv.substr(end);
  write_text_atomically(root_ / "patches.csv", moved);
  EXPECT_THAT(merged(patches).out, HasSubstr("1 of 5 views merged"));
  write_text_atomically(root_ / "patches.csv", csv);
  EXPECT_THAT(merged(patches).out, HasSubstr("1 of 5 views merged"));
  EXPECT_TRUE(views("drifting") == corrected);
}

TEST_F(MergeShard, BadPatchesAreRefusedBeforeTheFirstMerge) {
  capture("d");
  const CameraProfile camera = Dataset(root_ / "d").read_camera();
  const std::string width = std::to_string(camera.intrinsics.width_px);
  std::string csv = "view,x_px,y_px,width_px,height_px\n";
  for (int v = 0; v < kViews; ++v) csv += "view_00" + std::to_string(v) + ",4,6,40,16\n";
  const auto refused = [&](const std::string& text, const std::vector<std::string>& parts) {
    write_text_atomically(root_ / "patches.csv", text);
    expect_refused(run_program({"merge", path("d"), "--monitor-patch", path("patches.csv")}),
                   parts);
    EXPECT_TRUE(views("d").empty());
  };
  refused(csv.substr(0, csv.find("view_003")), {"no monitor patch for view_003"});
  refused(csv + "view_000,1,1,4,4\n", {"patches.csv:7", "second patch for view_000"});
  refused(csv + "view_010,1,1,4,4\n", {"view_010", "no such view"});
  for (const std::string& bad :
       {width + ",6,40,16", std::string("-1,6,40,16"), std::string("4,6,0,16")}) {
    std::string text = csv;
    text.replace(text.find("view_004"), std::string::npos, "view_004," + bad + "\n");
    refused(text, {"view_004", "not inside"});
  }

  // A hand before the patch of one view: that view is named.
  const CapturedView third = Dataset(root_ / "d").read_frames()[2];
  for (const ExposureRecord& e : third.exposures) {
    MosaicImage covered = read_mosaic_png(root_ / "d" / e.file, camera.pattern);
    for (std::uint16_t& dn : covered.dn)
      dn = static_cast<std::uint16_t>(camera.black_dn + std::max(dn - camera.black_dn, 0) / 2);
    write_mosaic_png(root_ / "d" / e.file, covered);
  }
  fs::remove_all(root_ / "d/session");
  std::string wall = "view,x_px,y_px,width_px,height_px\n";
  for (int v = 0; v < kViews; ++v)
    wall += "view_00" + std::to_string(v) + "," +
            std::to_string(camera.intrinsics.width_px / 2 - 20) + ",6,40,16\n";
  write_text_atomically(root_ / "patches.csv", wall);
  const Outcome outcome = run_program({"merge", path("d"), "--monitor-patch", path("patches.csv")});
  expect_refused(outcome, {"view_002: the monitor patch has ", "times the light of the first"});
}

TEST_F(MergeShard, AViewIsMergedAgainWhenItWouldComeOutDifferently) {
  capture("d");
  ASSERT_EQ(run("d"), 0);
  const auto first = views("d");
  const auto merged = [&](const std::vector<std::string>& said) {
    const Outcome outcome = run_program({"merge", path("d")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const std::string& part : said) EXPECT_THAT(outcome.err, HasSubstr(part));
    return outcome.out;
  };
  // A damaged file, a damaged or missing record.
  fs::resize_file(path("d/hdr/view_001.exr"), 5000);
  EXPECT_THAT(merged({"view_001.exr: merged again", "not the file that was written"}),
              HasSubstr("1 of 5 views merged, 4 there"));
  EXPECT_TRUE(views("d") == first);
  std::vector<std::byte> bytes = first.at("view_002");
  bytes[bytes.size() / 2] ^= std::byte{1};
  write_bytes_atomically(path("d/hdr/view_002.exr"), bytes);
  fs::remove(path("d/hdr/view_003.json"));
  write_text_atomically(path("d/hdr/view_004.json"), "{\"schema\": \"wheatstone-merged/1\"}");
  EXPECT_THAT(merged({"view_002.exr", "view_003.exr", "view_004.exr", "no record"}),
              HasSubstr("3 of 5 views merged"));
  EXPECT_TRUE(views("d") == first);

  // The camera: what merging uses of it, and what it does not.
  const Dataset dataset(root_ / "d");
  const CameraProfile camera = dataset.read_camera();
  CameraProfile other = camera;
  other.distortion.k1 += 0.01;
  dataset.write_camera(other);
  EXPECT_THAT(merged({}), HasSubstr("0 of 5 views merged"));
  other.dn_per_cd_m2_s *= 2;
  dataset.write_camera(other);
  EXPECT_THAT(merged({"view_000.exr: merged again", "camera"}), HasSubstr("5 of 5 views merged"));
  EXPECT_FALSE(views("d") == first);
  dataset.write_camera(camera);
  EXPECT_THAT(merged({}), HasSubstr("5 of 5 views merged"));
  EXPECT_TRUE(views("d") == first);

  // A frame taken anew, without a journal that knew the old one.
  fs::remove_all(path("d/session"));
  fs::copy_file(path("d/raw/view_000_exposure_0.png"), path("d/raw/view_001_exposure_0.png"),
                fs::copy_options::overwrite_existing);
  EXPECT_THAT(merged({"view_001.exr: merged again"}), HasSubstr("1 of 5 views merged"));
  EXPECT_FALSE(views("d") == first);
}

TEST_F(MergeShard, FramesThatTheJournalDoesNotKnowAreRefused) {
  capture("d");
  ASSERT_EQ(run("d", {"--shard", "1/5"}), 0);
  const std::string frame = path("d/raw/view_001_exposure_0.png");
  const std::vector<std::byte> good = read_bytes(frame);
  const auto refused = [&](const std::string& problem) {
    expect_refused(run_program({"merge", path("d")}),
                   {frame, problem, "run the same capture again"});
    EXPECT_EQ(views("d").size(), 1U);
  };
  fs::resize_file(frame, good.size() / 2);
  refused("by the session's journal");
  std::vector<std::byte> bad = good;
  bad[bad.size() / 2] ^= std::byte{1};
  write_bytes_atomically(frame, bad);
  refused("other contents");
  fs::remove(frame);
  refused("is missing");
  write_bytes_atomically(frame, good);
  EXPECT_EQ(run("d"), 0);
  EXPECT_EQ(views("d").size(), std::size_t{kViews});
  write_bytes_atomically(frame, bad);
  expect_refused(run_program({"merge", path("d")}), {frame, "other contents"});
}

TEST_F(MergeShard, UnmeasuredPixelsAndContradictoryExposuresAreSaid) {
  capture("d");
  fs::remove_all(path("d/session"));
  const Dataset dataset(root_ / "d");
  const CameraProfile camera = dataset.read_camera();
  std::vector<CapturedView> frames = dataset.read_frames();
  // The third view: a tenth of it beyond any exposure, another tenth without light.
  for (const ExposureRecord& e : frames[2].exposures) {
    MosaicImage frame = read_mosaic_png(dataset.file(e.file), camera.pattern);
    const int rows = frame.height() / 20 * 2;
    frame.dn.rowRange(0, rows) = camera.white_dn;
    frame.dn.rowRange(rows, 2 * rows) = camera.black_dn;
    write_mosaic_png(dataset.file(e.file), frame);
  }
  std::swap(frames[3].exposures[0].exposure_s, frames[3].exposures[1].exposure_s);
  dataset.write_frames(frames);
  for (const char* expected : {"5 of 5 views merged", "0 of 5 views merged"}) {
    const Outcome outcome = run_program({"merge", path("d")});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, AllOf(HasSubstr(expected), HasSubstr("of a view (view_002)")));
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("warning: "), HasSubstr("of view_002 are saturated"),
                                   HasSubstr("of view_002 are underexposed")));
    if (expected[0] == '5') {
      EXPECT_THAT(outcome.err, AllOf(HasSubstr("raw/view_003_exposure_0.png"),
                                     HasSubstr("raw/view_003_exposure_1.png")));
    }
  }
  const json record = read_json(path("d/hdr/view_002.json"), "wheatstone-merged/1");
  EXPECT_NEAR(record["saturated"].get<double>(), 0.1, 0.02);
  EXPECT_NEAR(record["underexposed"].get<double>(), 0.1, 0.02);
}

TEST_F(MergeShard, ACaptureThatIsWellExposedIsQuiet) {
  capture("d");
  const Outcome outcome = run_program({"merge", path("d")});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.err, testing::Not(HasSubstr("warning")));
}

TEST_F(MergeShard, WhatCannotBeMergedSaysWhatToDo) {
  ASSERT_EQ(run_program({"capture", path("d"), "--scale", "0.1", "--views", "3"}).status, 0);
  expect_refused(run_program({"calibrate", "poses", path("d")}),
                 {"hdr/view_000.exr", "is missing", "wheatstone merge"});
  EXPECT_FALSE(fs::exists(path("d/poses.json")));
  const Outcome idle = run_program({"merge", path("d"), "--shard", "6/6"});
  EXPECT_EQ(idle.status, 0) << idle.err;
  EXPECT_THAT(idle.out, AllOf(HasSubstr("6/6"), HasSubstr("nothing to do")));
  EXPECT_FALSE(fs::exists(path("d/hdr")));
  const Dataset field = write_small_light_field(root_ / "field");
  DatasetManifest manifest = field.read_manifest();
  manifest.kind = "light-field";
  field.write_manifest(manifest);
  expect_refused(run_program({"merge", path("field")}),
                 {"dataset.json", "is no capture but of kind light-field"});
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
  EXPECT_TRUE(records("sharded") == records("serial"));
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
  EXPECT_TRUE(records("killed") == records("serial"));
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
