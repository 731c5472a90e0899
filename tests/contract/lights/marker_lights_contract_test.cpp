// What all marker lights promise, whatever they are made of.

#include <gmock/gmock.h>

#include <stop_token>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/lights/lights_backends.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

struct Maker {
  const char* name;
  std::unique_ptr<LightsBackend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class MarkerLightsContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { warm_up_hid(); }

  MarkerLights& lights() { return backend_->lights(); }
  Deadline soon() { return backend_->clock().in(Duration::of(5)); }

  MockResources resources_{0.5};
  std::unique_ptr<LightsBackend> backend_ = GetParam().make();
};

TEST_P(MarkerLightsContract, SayWhoTheyAre) {
  EXPECT_FALSE(lights().identity().driver.empty());
  EXPECT_FALSE(lights().identity().model.empty());
  EXPECT_GE(lights().count(), 1);
  EXPECT_LE(lights().count(), 32);
}

TEST_P(MarkerLightsContract, AreDarkWhenOpened) {
  EXPECT_EQ(lights().state(soon()), 0U);
  EXPECT_EQ(backend_->truth(), 0U);
}

TEST_P(MarkerLightsContract, LightExactlyWhatIsAsked) {
  for (int i = 0; i < 2; ++i)
    for (MarkerLights::Mask mask = 0; mask <= lights().all(); ++mask) {
      lights().set(mask, soon());
      EXPECT_EQ(backend_->truth(), mask);
      EXPECT_EQ(lights().state(soon()), mask);
    }
}

TEST_P(MarkerLightsContract, MayBeSetTwice) {
  lights().set(lights().all(), soon());
  lights().set(lights().all(), soon());
  EXPECT_EQ(backend_->truth(), lights().all());
}

TEST_P(MarkerLightsContract, RefuseLightsThatTheyLack) {
  lights().set(1, soon());
  for (const int beyond : {lights().count(), 31}) {
    EXPECT_EQ(kind_of([&] { lights().set(MarkerLights::Mask{1} << beyond, soon()); }),
              Kind::kOutOfRange);
    EXPECT_EQ(
        kind_of([&] { lights().set(lights().all() | MarkerLights::Mask{1} << beyond, soon()); }),
        Kind::kOutOfRange);
  }
  EXPECT_EQ(backend_->truth(), 1U) << "nothing was sent";
  EXPECT_EQ(lights().state(soon()), 1U);
}

TEST_P(MarkerLightsContract, GoDarkAtOnce) {
  lights().set(lights().all(), soon());
  lights().all_off();
  EXPECT_EQ(backend_->truth(), 0U);
  EXPECT_EQ(lights().state(soon()), 0U);
  lights().all_off();
  lights().set(1, soon());
  EXPECT_EQ(backend_->truth(), 1U) << "they may be lit again";
}

TEST_P(MarkerLightsContract, GoDarkFromAnotherThread) {
  lights().set(lights().all(), soon());
  std::jthread([&] { lights().all_off(); }).join();
  EXPECT_EQ(backend_->truth(), 0U);
}

TEST_P(MarkerLightsContract, StayDarkWhoeverIsFaster) {
  MarkerLights& both = lights();
  for (int i = 0; i < 30; ++i) {
    std::jthread other([&] { both.all_off(); });
    const auto end = kind_of([&] { both.set(both.all(), soon()); });
    other.join();
    EXPECT_THAT(end, ::testing::AnyOf(std::nullopt, Kind::kRefused));
    if (end == Kind::kRefused) {
      EXPECT_EQ(backend_->truth(), 0U);
    }
    lights().all_off();
    EXPECT_EQ(backend_->truth(), 0U);
  }
}

TEST_P(MarkerLightsContract, KeepDeadlinesAndStopOnRequest) {
  lights().set(1, soon());
  const Deadline over{backend_->clock().now_ns()};
  EXPECT_EQ(kind_of([&] { lights().set(0, over); }), Kind::kTimeout);
  EXPECT_EQ(kind_of([&] { lights().state(over); }), Kind::kTimeout);
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(lights().set(0, {soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_THROW(lights().state({soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_EQ(backend_->truth(), 1U) << "nothing was sent";
  EXPECT_EQ(lights().state(soon()), 1U);
}

TEST_P(MarkerLightsContract, LeaveNothingLitBehind) {
  lights().set(lights().all(), soon());
  backend_->close();
  EXPECT_EQ(backend_->truth(), 0U);
}

TEST_P(MarkerLightsContract, StayGoneOnceTheyAreGone) {
  lights().set(lights().all(), soon());
  backend_->unplug();
  EXPECT_EQ(kind_of([&] { lights().state(soon()); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { lights().state(soon()); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { lights().set(1, soon()); }), Kind::kDisconnected);
  lights().all_off();
  EXPECT_EQ(backend_->truth(), 0U);
}

const Maker kMakers[] = {
    {"Twin",
     []() -> std::unique_ptr<LightsBackend> { return std::make_unique<TwinLightsBackend>(); }},
    {"HidRelay",
     []() -> std::unique_ptr<LightsBackend> { return std::make_unique<RelayBackend>(hid_bed()); }},
    {"Blink1", []() -> std::unique_ptr<LightsBackend> {
       return std::make_unique<Blink1Backend>(hid_bed());
     }}};

INSTANTIATE_TEST_SUITE_P(Lights, MarkerLightsContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace wheatstone
