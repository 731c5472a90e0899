// What every video camera promises, whatever it is made of.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/video/video_backends.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

const VideoMode kMode{"Y12 ", 320, 240, 100};
constexpr double kPeriodS = 0.01;

struct Maker {
  const char* name;
  std::unique_ptr<VideoBackend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class VideoContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { warm_up_video(); }

  VideoCamera& camera() { return backend_->camera(); }
  Deadline soon() { return backend_->clock().in(Duration::of(5)); }
  VideoSettings configure() { return camera().configure(kMode, Duration::of(0.004), 1, soon()); }
  void run() {
    configure();
    camera().start(soon());
  }

  VideoResources resources_;
  std::unique_ptr<VideoBackend> backend_ = GetParam().make();
};

TEST_P(VideoContract, SaysWhoItIs) {
  EXPECT_FALSE(camera().identity().driver.empty());
  EXPECT_FALSE(camera().identity().model.empty());
}

TEST_P(VideoContract, OffersModesWithFourCharacters) {
  const std::vector<VideoMode> modes = camera().modes(soon());
  EXPECT_THAT(modes, ::testing::Contains(kMode));
  for (const VideoMode& m : modes) {
    EXPECT_EQ(m.format.size(), 4U);
    EXPECT_GT(m.width_px * m.height_px, 0);
    EXPECT_GE(m.frames_per_s, 0);
  }
}

TEST_P(VideoContract, GrantsWhatItOffers) {
  const VideoSettings granted = configure();
  EXPECT_EQ(granted.mode, kMode);
  EXPECT_NEAR(granted.exposure.value(), 0.004, 1e-9);
  EXPECT_EQ(granted.gain, 1);
}

TEST_P(VideoContract, SaysHowItRoundsAnExposure) {
  const VideoSettings granted = camera().configure(kMode, Duration::of(0.00412), 1.2, soon());
  EXPECT_NEAR(granted.exposure.value(), 0.0041, 1e-9);
  EXPECT_EQ(granted.gain, 1);
}

TEST_P(VideoContract, RefusesWhatItDoesNotOffer) {
  const auto asked = [&](const VideoMode& mode, double exposure_s, double gain) {
    return kind_of([&] { camera().configure(mode, Duration::of(exposure_s), gain, soon()); });
  };
  EXPECT_EQ(asked({"Y12 ", 321, 240, 100}, 0.004, 1), Kind::kOutOfRange);
  EXPECT_EQ(asked({"XYZ0", 320, 240, 100}, 0.004, 1), Kind::kOutOfRange);
  EXPECT_EQ(asked({"", 320, 240, 100}, 0.004, 1), Kind::kOutOfRange);
  EXPECT_EQ(asked({"Y12 ", 320, 240, 101}, 0.004, 1), Kind::kOutOfRange);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double exposure_s : {0.0, -1.0, 1e9, kNan})
    EXPECT_EQ(asked(kMode, exposure_s, 1), Kind::kOutOfRange) << exposure_s;
  for (const double gain : {-1.0, 1e9, kNan})
    EXPECT_EQ(asked(kMode, 0.004, gain), Kind::kOutOfRange) << gain;
}

TEST_P(VideoContract, IsConfiguredThenStartedThenAskedForFrames) {
  EXPECT_EQ(kind_of([&] { camera().next(soon()); }), Kind::kNotReady);
  EXPECT_EQ(kind_of([&] { camera().start(soon()); }), Kind::kNotReady);
  configure();
  EXPECT_EQ(kind_of([&] { camera().next(soon()); }), Kind::kNotReady);
  camera().start(soon());
  EXPECT_EQ(kind_of([&] { configure(); }), Kind::kNotReady);
  EXPECT_EQ(camera().next(soon()).format, "Y12 ");
}

TEST_P(VideoContract, GivesFrameAfterFrameOnTime) {
  run();
  VideoFrame last = camera().next(soon());
  for (int i = 0; i < 20; ++i) {
    const VideoFrame frame = camera().next(soon());
    const std::uint32_t step = frame.sequence - last.sequence;
    ASSERT_GE(step, 1U);
    if (frame.time_is_the_cameras) {
      EXPECT_NEAR(static_cast<double>(frame.mid_exposure_ns - last.mid_exposure_ns) * 1e-9,
                  step * kPeriodS, 2e-6);
    }
    EXPECT_GT(frame.mid_exposure_ns, last.mid_exposure_ns);
    EXPECT_LT(frame.mid_exposure_ns, backend_->clock().now_ns());
    EXPECT_EQ(frame.pixels.size(), cv::Size(320, 240));
    EXPECT_EQ(frame.pixels.type(), CV_16UC1);
    last = frame;
  }
}

TEST_P(VideoContract, GivesTypesAsDocumented) {
  for (const auto& [format, type] : std::vector<std::pair<std::string, int>>{
           {"GREY", CV_8UC1}, {"Y12 ", CV_16UC1}, {"Y16 ", CV_16UC1}}) {
    camera().configure({format, 640, 480, 30}, Duration::of(0.004), 1, soon());
    camera().start(soon());
    const VideoFrame frame = camera().next(soon());
    EXPECT_EQ(frame.pixels.size(), cv::Size(640, 480));
    EXPECT_EQ(frame.pixels.type(), type) << format;
    EXPECT_EQ(frame.format, format);
    camera().stop();
  }
}

TEST_P(VideoContract, SeesTheLightOfTheBox) {
  const auto mean = [&](double led_drive, double exposure_s) {
    backend_->world().light.led_drive = led_drive;
    camera().configure(kMode, Duration::of(exposure_s), 1, soon());
    camera().start(soon());
    const double m = cv::mean(camera().next(soon()).pixels)[0];
    camera().stop();
    return m;
  };
  const double dark = mean(0, 0.004), lit = mean(1, 0.004), longer = mean(1, 0.008);
  EXPECT_GT(lit, dark + 20);
  EXPECT_NEAR((longer - dark) / (lit - dark), 2, 0.02);
}

TEST_P(VideoContract, FramesKeepTheirPixels) {
  run();
  const VideoFrame first = camera().next(soon());
  const cv::Mat copy = first.pixels.clone();
  for (int i = 0; i < 10; ++i) camera().next(soon());
  camera().stop();
  EXPECT_EQ(cv::norm(first.pixels, copy, cv::NORM_INF), 0);
}

TEST_P(VideoContract, CountsFramesThatNobodyFetched) {
  run();
  std::uint32_t before = camera().next(soon()).sequence;
  EXPECT_EQ(camera().dropped(), 0U);
  backend_->clock().wait_until(backend_->clock().in(Duration::of(30 * kPeriodS)).at_ns);
  std::uint64_t missing = 0;
  for (int i = 0; i < 10; ++i) {
    const std::uint32_t now = camera().next(soon()).sequence;
    missing += now - before - 1;
    before = now;
  }
  EXPECT_EQ(camera().dropped(), missing);
  if (backend_->counts_frames()) {
    EXPECT_GE(missing, 15U);
  }
}

TEST_P(VideoContract, StopsAndStartsAgain) {
  run();
  camera().next(soon());
  camera().stop();
  camera().stop();
  EXPECT_EQ(kind_of([&] { camera().next(soon()); }), Kind::kNotReady);
  camera().start(soon());
  camera().next(soon());
  EXPECT_EQ(camera().dropped(), 0U);
  camera().stop();
  configure();
}

TEST_P(VideoContract, CanBeStoppedFromAnotherThread) {
  run();
  camera().next(soon());
  std::jthread([&] { camera().stop(); }).join();
  EXPECT_EQ(kind_of([&] { camera().next(soon()); }), Kind::kNotReady);
}

TEST_P(VideoContract, KeepsDeadlinesAndStopsOnRequest) {
  run();
  const Nanoseconds now = backend_->clock().now_ns();
  EXPECT_EQ(kind_of([&] { camera().next({now}); }), Kind::kTimeout);
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(camera().next({soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_THROW(camera().modes({soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_NO_THROW(camera().next(soon()));
}

TEST_P(VideoContract, StaysGoneOnceItIsGone) {
  run();
  backend_->unplug();
  EXPECT_EQ(kind_of([&] {
              for (int i = 0; i < 100; ++i) camera().next(soon());
            }),
            Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { camera().next(soon()); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { camera().modes(soon()); }), Kind::kDisconnected);
  camera().stop();
  EXPECT_EQ(kind_of([&] { camera().start(soon()); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { configure(); }), Kind::kDisconnected);
}

const Maker kMakers[] = {
    {"Twin",
     []() -> std::unique_ptr<VideoBackend> { return std::make_unique<TwinVideoBackend>(); }},
    {"V4l2Mmap",
     []() -> std::unique_ptr<VideoBackend> {
       return std::make_unique<V4l2Backend>(video_bed(), V4l2Transfer::kMmap);
     }},
    {"V4l2UserPointer",
     []() -> std::unique_ptr<VideoBackend> {
       return std::make_unique<V4l2Backend>(video_bed(), V4l2Transfer::kUserPointer);
     }},
    {"V4l2Read", []() -> std::unique_ptr<VideoBackend> {
       return std::make_unique<V4l2Backend>(video_bed(), V4l2Transfer::kRead);
     }}};

INSTANTIATE_TEST_SUITE_P(Cameras, VideoContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace wheatstone
