// A session on the twin, ended in every way that the rig knows, loses nothing and mislabels
// nothing.
#include "capture/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <span>

#include "core/digest.h"
#include "core/error.h"
#include "core/files.h"
#include "core/journal.h"
#include "core/png.h"
#include "tests/dataset_contents.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"
#include "troubled_rig.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

const CapturePlan kPlan{3, {1 / 240.0, 1 / 15.0}};
constexpr int kFrames = 3 * 3 + 1;
const DatasetManifest kManifest{"capture", "card", 7, 0.05, "simulated rig", 0, 1};

class SessionTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    TroubledRig rig;
    capture_light_field(rig.rig(), Dataset(folder.path), kManifest, kPlan, {});
    whole_ = dataset_contents(folder.path);
  }

  static std::string capture(TroubledRig& rig, const fs::path& root,
                             const CapturePlan& plan = kPlan, const CaptureListener& l = {}) {
    const std::string error =
        error_of([&] { capture_light_field(rig.rig(), Dataset(root), kManifest, plan, l); });
    EXPECT_TRUE(rig.dark()) << error;
    EXPECT_FALSE(rig.moved_with_open_shutter) << error;
    return error;
  }

  /// Ends the session with `trouble`, expects `what` in the message and no dataset; then goes on
  /// with a new rig and expects what an undisturbed session writes.
  void expect_resumable(const std::function<void(TroubledRig&)>& trouble, const std::string& what) {
    const TemporaryFolder folder;
    TroubledRig rig;
    trouble(rig);
    EXPECT_THAT(capture(rig, folder.path), HasSubstr(what));
    EXPECT_FALSE(fs::exists(folder.path / "dataset.json")) << what;
    TroubledRig another_day;
    const auto taken = static_cast<int>(
        kFrames - missing_shots(another_day.rig(), Dataset(folder.path), kManifest, kPlan).size());
    EXPECT_EQ(capture(another_day, folder.path), "no error") << what;
    EXPECT_EQ(another_day.frames, kFrames - taken) << "only what is missing: " << what;
    EXPECT_TRUE(dataset_contents(folder.path) == whole_) << what;
  }

  static inline std::map<std::string, std::vector<std::byte>> whole_;
  const TemporaryFolder folder_;
};

/// The twin's ceiling on a supply that carries only so much of it.
class WeakCeiling final : public LedArray {
 public:
  WeakCeiling(LedArray& leds, double most) : leds_(leds), most_(most) {}
  DeviceIdentity identity() const override { return leds_.identity(); }
  int rows() const override { return leds_.rows(); }
  int columns() const override { return leds_.columns(); }
  double max_mean_drive() const override { return most_; }
  void set_frame(const LedFrame& frame, Deadline deadline) override {
    require_valid(*this, frame);
    brightest = std::max(brightest, mean_drive(frame));
    leds_.set_frame(frame, std::move(deadline));
  }
  void all_off() noexcept override { leds_.all_off(); }

  double brightest = 0;

 private:
  LedArray& leds_;
  double most_;
};

TEST_F(SessionTest, TheCeilingIsLitAsFarAsItMay) {
  TroubledRig rig;
  WeakCeiling weak(*rig.rig().leds, 0.3);
  Rig limited = rig.rig();
  limited.leds = weak;
  const Dataset dataset(folder_.path);
  capture_light_field(limited, dataset, kManifest, kPlan, {});
  EXPECT_NEAR(weak.brightest, 0.3, 1e-6);
  EXPECT_FALSE(dataset_contents(folder_.path) == whole_);
  // On another day it may shine brighter, which would be another light field.
  EXPECT_THAT(error_of([&] { capture_light_field(rig.rig(), dataset, kManifest, kPlan, {}); }),
              HasSubstr("ceiling_drive: 0.3 there, 1.0 asked for"));
}

TEST_F(SessionTest, WritesEveryFrameWithItsRecord) {
  TroubledRig rig;
  ASSERT_EQ(capture(rig, folder_.path), "no error");
  EXPECT_EQ(rig.frames, kFrames);
  const Dataset dataset(folder_.path);
  const std::vector<CapturedView> views = dataset.read_frames();
  ASSERT_EQ(views.size(), 3U);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(views[i].reached_mm, rig.reached_mm[i]);
    EXPECT_EQ(views[i].exposures.size(), 2U);
  }
  std::map<std::string, json> frames;
  for (const json& r : Journal::read(folder_.path / "session/journal.jsonl"))
    if (r.at("event") == "frame") frames[r.at("file")] = r;
  ASSERT_EQ(frames.size(), static_cast<std::size_t>(kFrames));
  for (const auto& [file, r] : frames) {
    EXPECT_EQ(r.at("bytes"), fs::file_size(folder_.path / file));
    EXPECT_EQ(r.at("light"), file.find("markers") == std::string::npos ? "ceiling" : "markers");
    EXPECT_EQ(r.at("camera_serial"), rig.rig().camera_profile.serial);
    EXPECT_GT(r.at("triggered_ns"), 0);
  }
  EXPECT_EQ(dataset.read_manifest().scene, "card");
}

TEST_F(SessionTest, OneViewOfOneExposure) {
  TroubledRig rig;
  EXPECT_EQ(capture(rig, folder_.path, {1, {1 / 60.0}}), "no error");
  EXPECT_EQ(rig.frames, 2);
  EXPECT_EQ(Dataset(folder_.path).read_frames().size(), 1U);
}

TEST_F(SessionTest, TakesAsLongAsForeseen) {
  TroubledRig rig;
  const Rig devices = rig.rig();
  CapturePlan plan = kPlan;
  plan.settle_s = 0.3;
  const CaptureForecast seen = forecast(shots_of(plan, devices.stage->travel()), plan, devices);
  EXPECT_EQ(capture(rig, folder_.path, plan), "no error");
  const double home_s = devices.stage->move_duration(Length::of(0)).value();
  EXPECT_NEAR(seen.duration_s + home_s, static_cast<double>(rig.world().clock.now_ns()) * 1e-9,
              0.01 * seen.duration_s);
  EXPECT_EQ(seen.frames, kFrames);
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path / "raw")) bytes += entry.file_size();
  EXPECT_LE(bytes, seen.bytes);
  EXPECT_GE(bytes, seen.bytes / 4);
}

TEST_F(SessionTest, CameraUnpluggedAtAnyFrame) {
  for (const int n : {0, 1, 2, 5, kFrames - 1})
    expect_resumable(
        [n](TroubledRig& rig) {
          rig.before_frame = [n](int frame) {
            if (frame == n)
              throw DeviceError(DeviceError::Kind::kDisconnected, "the camera is gone",
                                "plug it in");
          };
        },
        "the camera is gone");
}

TEST_F(SessionTest, ShutterLeftOpenIsWaitedFor) {
  // The camera times out with its shutter open; the world's clock goes on in the second run.
  TroubledRig rig;
  rig.before_frame = [](int frame) {
    if (frame == 1) throw DeviceError(DeviceError::Kind::kTimeout, "no answer", "try again");
  };
  CapturePlan plan = kPlan;
  plan.exposures_s[1] = 20;
  EXPECT_THAT(capture(rig, folder_.path, plan), HasSubstr("no answer"));
  rig.before_frame = nullptr;
  EXPECT_EQ(capture(rig, folder_.path, plan), "no error");
}

TEST_F(SessionTest, RailStalledAtAnyMove) {
  for (int n = 0; n < 4; ++n)
    expect_resumable(
        [n](TroubledRig& rig) {
          rig.before_move = [n](int move) {
            if (move == n)
              throw DeviceError(DeviceError::Kind::kTimeout, "the rail is stuck", "free it");
          };
        },
        "the rail is stuck");
}

TEST_F(SessionTest, RailThatStopsShortIsNoticed) {
  expect_resumable(
      [](TroubledRig& rig) {
        rig.after_move = [](int move, Length reached) {
          return move == 1 ? Length::of(reached.value() - 1) : reached;
        };
      },
      "instead of 83.500 mm");
}

TEST_F(SessionTest, FrameThatIsNotTheOneAskedForIsRefused) {
  const auto spoil = [&](const std::function<void(RawFrame&)>& change, const std::string& what) {
    expect_resumable(
        [&](TroubledRig& rig) {
          rig.after_frame = [&change](int frame, RawFrame& raw) {
            if (frame == 4) change(raw);
          };
        },
        what);
  };
  spoil([](RawFrame& raw) { raw.triggered_ns -= 1'000'000'000; }, "older frame");
  spoil([](RawFrame& raw) { raw.camera_serial = "another"; }, "'another'");
  spoil([](RawFrame& raw) { raw.exposure = Duration::of(1.2 * raw.exposure.value()); },
        "instead of");
  spoil([](RawFrame& raw) { raw.gain = 4; }, "ISO 400");
  spoil([](RawFrame& raw) { raw.mosaic.dn = raw.mosaic.dn(cv::Rect(0, 0, 8, 8)).clone(); }, "8x8");
  spoil([](RawFrame& raw) { raw.mosaic.pattern = BayerPattern::kGbrg; }, "GBRG");
}

TEST_F(SessionTest, CancelledAtAnyStep) {
  const auto cancelled = [&](const auto& arrange, const std::string& when) {
    const TemporaryFolder folder;
    TroubledRig rig;
    std::stop_source source;
    arrange(rig, source);
    EXPECT_THAT(capture(rig, folder.path, kPlan, {{}, {}, source.get_token()}),
                HasSubstr("resume"));
    TroubledRig again;
    EXPECT_EQ(capture(again, folder.path), "no error");
    EXPECT_EQ(rig.frames + again.frames, kFrames) << when;
    EXPECT_TRUE(dataset_contents(folder.path) == whole_) << when;
  };
  cancelled([](TroubledRig&, std::stop_source& source) { source.request_stop(); }, "at once");
  for (const int n : {0, 1, 2, 5, 8}) {
    cancelled(
        [n](TroubledRig& rig, std::stop_source& source) {
          rig.after_frame = [&source, n](int frame, RawFrame&) {
            if (frame == n) source.request_stop();
          };
        },
        "after frame " + std::to_string(n));
  }
  for (const int n : {0, 1, 2}) {
    cancelled(
        [n](TroubledRig& rig, std::stop_source& source) {
          rig.before_move = [&source, n](int move) {
            if (move == n) source.request_stop();
          };
        },
        "in move " + std::to_string(n));
  }
}

TEST_F(SessionTest, FailingDevicesLoseNothing) {
  int all_failures = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const TemporaryFolder folder;
    int failures = 0;
    for (std::string error = "none yet"; error != "no error"; ++failures) {
      ASSERT_LT(failures, 100);
      TroubledRig rig;
      rig.world().faults.arm_at_random(0.08, 100 * seed + static_cast<std::uint64_t>(failures));
      error = capture(rig, folder.path);
      EXPECT_TRUE(rig.dark()) << error;
    }
    all_failures += failures - 1;
    EXPECT_TRUE(dataset_contents(folder.path) == whole_) << seed;
  }
  EXPECT_GT(all_failures, 3) << "the devices did fail";
}

TEST_F(SessionTest, AFinishedSessionTakesNothingAgain) {
  TroubledRig rig, again;
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  EXPECT_EQ(capture(again, folder_.path), "no error");
  EXPECT_EQ(again.frames + again.moves, 0);
  EXPECT_TRUE(dataset_contents(folder_.path) == whole_);
}

TEST_F(SessionTest, DamagedAndLostFilesAreTakenAgainAndNothingIsDeleted) {
  TroubledRig rig, again;
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  const fs::path damaged = folder_.path / "raw/view_001_exposure_0.png",
                 swapped = folder_.path / "raw/view_001_markers.png";
  std::fstream(damaged, std::ios::in | std::ios::out).seekp(100).put('x');
  std::ofstream(swapped) << "short";
  fs::remove(folder_.path / "raw/view_002_exposure_1.png");
  EXPECT_EQ(capture(again, folder_.path), "no error");
  EXPECT_EQ(again.frames, 3);
  EXPECT_TRUE(dataset_contents(folder_.path) == whole_);
  int kept = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path / "session/set_aside"))
    kept += entry.is_regular_file();
  EXPECT_EQ(kept, 2);
}

/// A camera that makes files of its own.
void make_files(TroubledRig& rig) {
  rig.after_frame = [](int, RawFrame& frame) {
    const auto bytes = std::as_bytes(std::span(frame.mosaic.dn[0], 64));
    frame.file.assign(bytes.begin(), bytes.end());
    frame.file_type = "ARW";
  };
}

TEST_F(SessionTest, TheCamerasOwnFilesAreKeptBesideTheFrames) {
  TroubledRig rig;
  make_files(rig);
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  std::map<std::string, std::vector<std::byte>> contents = dataset_contents(folder_.path);
  int files = 0;
  for (const json& record : Journal::read(folder_.path / "session/journal.jsonl")) {
    if (record.at("event") != "frame") continue;
    const json& own = record.at("camera_file");
    EXPECT_EQ(own.at("file"),
              fs::path(record.at("file").get<std::string>()).replace_extension("ARW").string());
    const auto bytes = read_bytes(folder_.path / own.at("file").get<std::string>());
    EXPECT_EQ(own.at("bytes"), bytes.size());
    EXPECT_EQ(own.at("sha256"), sha256_hex(bytes));
    contents.erase(own.at("file"));
    ++files;
  }
  EXPECT_EQ(files, kFrames);
  EXPECT_TRUE(contents == whole_) << "all else is as without them";
}

TEST_F(SessionTest, TheForecastHasRoomForTheCamerasOwnFiles) {
  TroubledRig rig;
  const auto bytes = [&] {
    const Rig devices = rig.rig();
    return forecast(shots_of(kPlan, devices.stage->travel()), kPlan, devices).bytes;
  };
  const std::uintmax_t without = bytes();
  rig.file_bytes = 12'345;
  EXPECT_EQ(bytes(), without + kFrames * std::uintmax_t{12'345});
  rig.file_bytes = UINT64_C(1) << 56;  // no disk has so much for each frame
  EXPECT_THAT(capture(rig, folder_.path), ::testing::HasSubstr("the disk has"));
  EXPECT_EQ(rig.frames, 0);
}

TEST_F(SessionTest, DamagedAndLostCameraFilesAreTakenAgainWithTheirFrames) {
  TroubledRig rig, again;
  make_files(rig);
  make_files(again);
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  const auto whole = dataset_contents(folder_.path);
  std::fstream(folder_.path / "raw/view_001_exposure_0.ARW", std::ios::in | std::ios::out)
      .seekp(100)
      .put('x');
  fs::remove(folder_.path / "raw/view_002_exposure_1.ARW");
  EXPECT_EQ(capture(again, folder_.path), "no error");
  EXPECT_EQ(again.frames, 2);
  EXPECT_TRUE(dataset_contents(folder_.path) == whole);
  std::map<std::string, int> kept;
  for (const auto& entry : fs::directory_iterator(folder_.path / "session/set_aside"))
    ++kept[entry.path().extension()];
  EXPECT_EQ(kept[".ARW"], 1);
  EXPECT_EQ(kept[".png"], 2);
}

TEST_F(SessionTest, CameraFilesOfUnfitTypesAreRefused) {
  for (const char* type : {"", "png", "A/B", "..", "LONGER_THAN_ALL"}) {
    const TemporaryFolder folder;
    TroubledRig rig;
    rig.after_frame = [&](int, RawFrame& frame) {
      frame.file.resize(5);
      frame.file_type = type;
    };
    EXPECT_THAT(capture(rig, folder.path), HasSubstr("raw files")) << type;
    EXPECT_FALSE(fs::exists(folder.path / "raw/view_000_markers.png")) << type;
  }
}

TEST_F(SessionTest, FramesOfOneViewComeFromOnePlace) {
  TroubledRig rig, again;
  rig.before_frame = [](int frame) {
    if (frame == 4) throw DeviceError(DeviceError::Kind::kDisconnected, "gone", "plug it in");
  };
  EXPECT_THAT(capture(rig, folder_.path), HasSubstr("gone"));
  again.after_move = [](int, Length reached) { return Length::of(reached.value() + 0.05); };
  EXPECT_EQ(capture(again, folder_.path), "no error");
  EXPECT_EQ(again.frames, kFrames - 3) << "view_001 begins anew, view_000 stays";
  for (const CapturedView& view : Dataset(folder_.path).read_frames())
    EXPECT_EQ(view.exposures.size(), 2U);
  EXPECT_TRUE(fs::exists(folder_.path / "session/set_aside"));
}

TEST_F(SessionTest, AnotherPlanIsRefusedWithTheDifference) {
  TroubledRig rig;
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  CapturePlan plan = kPlan;
  plan.views = 5;
  plan.settle_s = 1;
  const std::string error = capture(rig, folder_.path, plan);
  EXPECT_THAT(error, HasSubstr("plan/views: 3 there, 5 asked for"));
  EXPECT_THAT(error, HasSubstr("plan/settle_s"));
  TroubledRig other_scene({"sphere", 0.05, 7});
  DatasetManifest manifest = kManifest;
  manifest.scene = "sphere";
  EXPECT_THAT(error_of([&] {
                capture_light_field(other_scene.rig(), Dataset(folder_.path), manifest, kPlan, {});
              }),
              HasSubstr("scene: \"card\" there, \"sphere\" asked for"));
  EXPECT_TRUE(dataset_contents(folder_.path) == whole_) << "nothing has changed";
}

TEST_F(SessionTest, OtherDatasetsAreLeftAlone) {
  TroubledRig rig;
  const Dataset dataset(folder_.path);
  make_folder(dataset.file("raw"));
  EXPECT_THAT(capture(rig, folder_.path), HasSubstr("no session's journal"));
  dataset.write_manifest(kManifest);
  EXPECT_THAT(capture(rig, folder_.path), HasSubstr("holds a dataset already"));
  EXPECT_FALSE(fs::exists(dataset.file("session")));
  EXPECT_EQ(rig.frames + rig.moves, 0);
}

TEST_F(SessionTest, AFolderInUseIsRefused) {
  make_folder(folder_.path / "session");
  const Journal other(folder_.path / "session/journal.jsonl");
  TroubledRig rig;
  EXPECT_THAT(capture(rig, folder_.path), HasSubstr("in use"));
  EXPECT_EQ(rig.frames + rig.moves, 0);
}

TEST_F(SessionTest, ADamagedJournalIsRefused) {
  TroubledRig rig;
  EXPECT_EQ(capture(rig, folder_.path), "no error");
  const fs::path journal = folder_.path / "session/journal.jsonl";
  const std::string good = read_text(journal);
  const auto expect = [&](std::string from, const std::string& to, const std::string& what) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    std::ofstream(journal) << text;
    EXPECT_THAT(capture(rig, folder_.path), HasSubstr(what));
    EXPECT_EQ(read_text(journal), text);
  };
  expect("\"event\":\"frame\"", "\"event\":\"frame", "damaged");
  expect("\"sha256\":", "\"sha\":", "sha256");
  expect("\"bytes\":", "\"bytes\":\"many\",\"b\":", "bytes");
  expect("wheatstone-session/1", "wheatstone-session/9", "wheatstone-session/9");
  expect("\"event\":\"session\"", "\"event\":7", "event");
}

TEST_F(SessionTest, BacklashShowsWhereTheEncoderSeesNone) {
  for (const double backlash_mm : {0.0, 0.5}) {
    const TemporaryFolder folder;
    TroubledRig rig({"card", 0.1, 7});
    rig.world().backlash_mm = backlash_mm;
    json returned;
    EXPECT_EQ(capture(rig, folder.path, {2, {1 / 60.0}},
                      {[&](const json& r) {
                         if (r.at("event") == "returned") returned = r;
                       },
                       {},
                       {}}),
              "no error");
    ASSERT_TRUE(returned.contains("seen_mm")) << returned;
    EXPECT_NEAR(returned.at("encoder_mm"), 0, 0.05);
    EXPECT_NEAR(returned.at("seen_mm").get<double>() - returned.at("encoder_mm").get<double>(),
                backlash_mm, 0.02);
  }
}

}  // namespace
}  // namespace wheatstone
