#pragma once
// What every LED array promises, whatever it is made of. Included by the programs that name the
// backends.

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/leds/led_backends.h"

namespace wheatstone {

struct LedMaker {
  const char* name;
  std::function<std::unique_ptr<LedBackend>()> make;
};
inline void PrintTo(const LedMaker& maker, std::ostream* out) {
  *out << maker.name;
}

class LedContract : public ::testing::TestWithParam<LedMaker> {
 protected:
  using Kind = DeviceError::Kind;

  LedArray& leds() { return backend_->leds(); }
  Deadline soon() { return backend_->clock().in(Duration::of(2)); }
  LedFrame frame(double drive) {
    return {cv::Mat3f(leds().rows(), leds().columns(), cv::Vec3f::all(static_cast<float>(drive)))};
  }

  std::unique_ptr<LedBackend> backend_ = GetParam().make();
};

TEST_P(LedContract, SaysWhoItIs) {
  EXPECT_FALSE(leds().identity().driver.empty());
  EXPECT_FALSE(leds().identity().model.empty());
  EXPECT_EQ(leds().rows(), 16);
  EXPECT_EQ(leds().columns(), 16);
}

TEST_P(LedContract, IsDarkWhenOpened) {
  leds();
  EXPECT_TRUE(backend_->shows(0));
}

TEST_P(LedContract, ShowsLinearLight) {
  for (const double drive : {0.7, 0.5, 0.1, 0.02, 0.0}) {
    leds().set_all(drive, soon());
    EXPECT_TRUE(backend_->shows(drive)) << drive << " became " << backend_->light();
  }
}

TEST_P(LedContract, ShowsPatterns) {
  LedFrame f = frame(0);
  for (int y = 0; y < 4; ++y) f.drive.row(y).setTo(cv::Scalar::all(1));
  leds().set_frame(f, soon());
  EXPECT_TRUE(backend_->shows(0.25)) << backend_->light();
}

TEST_P(LedContract, RefusesWhatIsNoFrame) {
  leds().set_all(0.5, soon());
  ASSERT_TRUE(backend_->shows(0.5));
  const auto asked = [&](const LedFrame& f) {
    return kind_of([&] { leds().set_frame(f, soon()); });
  };
  EXPECT_EQ(asked({}), Kind::kOutOfRange);
  EXPECT_EQ(asked({cv::Mat3f::zeros(15, 16)}), Kind::kOutOfRange);
  EXPECT_EQ(asked({cv::Mat3f::zeros(16, 17)}), Kind::kOutOfRange);
  for (const float bad : {-0.01F, 1.01F, std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()}) {
    LedFrame f = frame(0.5);
    f.drive(15, 15)[2] = bad;
    EXPECT_EQ(asked(f), Kind::kOutOfRange) << bad;
  }
  EXPECT_NEAR(backend_->light(), 0.5, 0.01);
}

TEST_P(LedContract, ShowsTheMostThatIsAllowedAndNoMore) {
  const double most = leds().max_mean_drive();
  ASSERT_GT(most, 0);
  ASSERT_LE(most, 1);
  leds().set_all(most, soon());
  EXPECT_TRUE(backend_->shows(most));
  if (most < 1) {
    EXPECT_EQ(kind_of([&] { leds().set_all(most + 0.01, soon()); }), Kind::kOutOfRange);
    EXPECT_NEAR(backend_->light(), most, 0.01);
  }
}

TEST_P(LedContract, GoesDark) {
  leds().set_all(0.5, soon());
  ASSERT_TRUE(backend_->shows(0.5));
  leds().all_off();
  EXPECT_TRUE(backend_->shows(0));
  leds().all_off();
  leds().set_all(0.5, soon());
  EXPECT_TRUE(backend_->shows(0.5)) << "and lights again";
  std::jthread([&] { leds().all_off(); }).join();
  EXPECT_TRUE(backend_->shows(0)) << "from another thread";
}

TEST_P(LedContract, IsDarkAfterAnyMixOfFramesAndAllOff) {
  leds();
  std::jthread lighting([&](const std::stop_token& stop) {
    const auto light = [&] {
      kind_of([&] { leds().set_all(0.5, soon()); });  // refused when it was overtaken
    };
    for (int i = 0; i < 50 && !stop.stop_requested(); ++i) light();
  });
  // The twin's devices are not for several threads.
  if (std::string(GetParam().name) == "Twin") lighting.join();
  for (int i = 0; i < 20; ++i) leds().all_off();
  if (lighting.joinable()) lighting.join();
  leds().all_off();
  EXPECT_TRUE(backend_->shows(0));
}

TEST_P(LedContract, StopsOnRequestAndShowsWhatItDid) {
  leds().set_all(0.5, soon());
  ASSERT_TRUE(backend_->shows(0.5));
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(leds().set_all(0.1, {soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_NEAR(backend_->light(), 0.5, 0.01);
  leds().set_all(0.1, soon());
  EXPECT_TRUE(backend_->shows(0.1));
}

TEST_P(LedContract, StaysGoneOnceItIsGone) {
  leds().set_all(0.1, soon());
  backend_->unplug();
  EXPECT_EQ(kind_of([&] {
              for (int i = 0; i < 3; ++i) leds().set_all(0.2, soon());
            }),
            Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { leds().set_all(0.2, soon()); }), Kind::kDisconnected);
  leds().all_off();
}

TEST_P(LedContract, LeavesDarkness) {
  leds().set_all(0.5, soon());
  ASSERT_TRUE(backend_->shows(0.5));
  backend_->close();
  if (std::string(GetParam().name) != "Twin") {
    EXPECT_TRUE(backend_->shows(0));
  }
}

}  // namespace wheatstone
