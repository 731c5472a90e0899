// What every still camera promises, whatever it is made of.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <thread>

#include "core/camera_raw.h"
#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/still/still_backends.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

const Duration kFirst = Duration::of(kSeriesS[0]);

struct Maker {
  const char* name;
  std::unique_ptr<StillBackend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class StillContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { warm_up_still(); }

  StillCamera& camera() { return backend_->camera(); }
  Deadline soon() { return backend_->clock().in(Duration::of(5)); }

  StillResources resources_;
  std::unique_ptr<StillBackend> backend_ = GetParam().make();
};

TEST_P(StillContract, SaysWhoItIs) {
  EXPECT_FALSE(camera().identity().driver.empty());
  EXPECT_FALSE(camera().identity().model.empty());
  EXPECT_FALSE(camera().identity().serial.empty());
}

TEST_P(StillContract, OffersTheNearestExposure) {
  const double offered = camera().offered_exposure(Duration::of(1 / 240.0)).value();
  EXPECT_LE(std::abs(std::log2(offered * 240)), 1.0 / 6);
  EXPECT_EQ(camera().offered_exposure(Duration::of(offered)).value(), offered);
  EXPECT_GE(camera().frame_duration(kFirst), kFirst);
}

TEST_P(StillContract, RefusesExposuresThatItCannotTake) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double seconds : {0.0, -1.0, 1e-6, 1e4, kNan}) {
    EXPECT_EQ(kind_of([&] { camera().offered_exposure(Duration::of(seconds)); }), Kind::kOutOfRange)
        << seconds;
    EXPECT_EQ(kind_of([&] { camera().expose(Duration::of(seconds), soon()); }), Kind::kOutOfRange)
        << seconds;
  }
}

TEST_P(StillContract, SaysWhatItTook) {
  const Nanoseconds before = backend_->clock().now_ns();
  const RawFrame frame = camera().expose(kFirst, soon());
  EXPECT_EQ(frame.exposure,
            camera().identity().driver == "replay" ? kFirst : camera().offered_exposure(kFirst));
  EXPECT_EQ(frame.gain, 1);
  EXPECT_EQ(frame.camera_serial, backend_->world().camera_profile.serial);
  EXPECT_GE(frame.triggered_ns, before);
  EXPECT_LE(frame.triggered_ns, backend_->clock().now_ns());
  EXPECT_EQ(frame.mosaic.width(), backend_->world().camera_profile.intrinsics.width_px);
  EXPECT_EQ(frame.mosaic.height(), backend_->world().camera_profile.intrinsics.height_px);
  EXPECT_EQ(frame.mosaic.pattern, backend_->world().camera_profile.pattern);
}

TEST_P(StillContract, ItsOwnFileHoldsTheSamePicture) {
  const RawFrame frame = camera().expose(kFirst, soon());
  EXPECT_EQ(frame.file.empty(), frame.file_type.empty());
  const std::uintmax_t most = camera().largest_file(frame.mosaic.dn.total());
  EXPECT_EQ(most == 0, frame.file.empty());
  EXPECT_LE(frame.file.size(), most);
  if (frame.file.empty()) return;  // the twin makes none
  const CameraRaw raw = decode_camera_raw(frame.file, "frame." + frame.file_type);
  EXPECT_EQ(cv::norm(raw.mosaic.dn, frame.mosaic.dn, cv::NORM_INF), 0);
  EXPECT_EQ(raw.exposure_s, frame.exposure.value());
}

TEST_P(StillContract, LongerExposuresAreBrighter) {
  backend_->world().light.led_drive = 1;
  double last = 0;
  for (const double seconds : kSeriesS) {
    const RawFrame frame = camera().expose(Duration::of(seconds), soon());
    const double mean = cv::mean(frame.mosaic.dn)[0];
    EXPECT_GT(mean, last) << seconds;
    last = mean;
  }
}

TEST_P(StillContract, SeesTheLightOfTheBox) {
  if (!backend_->sees()) return;  // a recording shows what was
  const auto mean = [&](double drive) {
    backend_->world().light.led_drive = drive;
    return cv::mean(camera().expose(kFirst, soon()).mosaic.dn)[0];
  };
  const double dark = mean(0);
  EXPECT_GT(mean(1), dark + 10);
}

TEST_P(StillContract, KeepsItsDeadline) {
  camera();
  SteadyClock machine;
  const Nanoseconds start = machine.now_ns();
  EXPECT_EQ(kind_of([&] {
              const Deadline over{backend_->clock().now_ns() - 1, {}};
              camera().expose(kFirst, over);
            }),
            Kind::kTimeout);
  EXPECT_LE(machine.now_ns() - start, 500'000'000);
  EXPECT_EQ(camera().expose(kFirst, soon()).exposure, kFirst) << "works again";
}

TEST_P(StillContract, StopsWhenAskedTo) {
  camera();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(camera().expose(kFirst, backend_->clock().in(Duration::of(5), stop.get_token())),
               Cancelled);
  EXPECT_EQ(camera().expose(kFirst, soon()).exposure, kFirst) << "works again";
}

TEST_P(StillContract, MayBeAbortedAtAnyTime) {
  camera().abort();
  EXPECT_EQ(camera().expose(kFirst, soon()).exposure, kFirst);
  camera().abort();
}

TEST_P(StillContract, StaysDisconnected) {
  camera().expose(kFirst, soon());
  resources_.pardon_libgphoto2();
  backend_->unplug();
  for (int i = 0; i < 2; ++i)
    EXPECT_EQ(kind_of([&] { camera().expose(Duration::of(kSeriesS[1]), soon()); }),
              Kind::kDisconnected);
}

template <class B>
std::unique_ptr<StillBackend> make() {
  return std::make_unique<B>();
}
INSTANTIATE_TEST_SUITE_P(Cameras, StillContract,
                         ::testing::Values(Maker{"Twin", make<TwinStillBackend>},
                                           Maker{"Gphoto", make<GphotoBackend>},
                                           Maker{"Replay", make<ReplayStillBackend>}),
                         [](const auto& maker) { return maker.param.name; });

TEST(StillOnTheWire, TakesWhatTheTwinTakes) {
  TwinStillBackend twin;
  GphotoBackend wire;
  for (StillBackend* b : {static_cast<StillBackend*>(&twin), static_cast<StillBackend*>(&wire)}) {
    b->world().light.led_drive = 0.5;
    b->world().move_carriage(40);
  }
  for (int round = 0; round < 2; ++round)
    for (const double seconds : kSeriesS) {
      const auto take = [&](StillBackend& b) {
        return b.camera().expose(Duration::of(seconds), b.clock().in(Duration::of(5)));
      };
      const RawFrame expected = take(twin), frame = take(wire);
      EXPECT_EQ(cv::norm(frame.mosaic.dn, expected.mosaic.dn, cv::NORM_INF), 0);
      EXPECT_EQ(frame.exposure, expected.exposure);
      EXPECT_EQ(frame.gain, expected.gain);
      EXPECT_EQ(frame.camera_serial, expected.camera_serial);
    }
}

}  // namespace
}  // namespace wheatstone
