// Every line of the table of faults of the Fadecandy, carried out; and what is no fault but looks
// like one.

#include <gmock/gmock.h>

#include <opencv2/core.hpp>
#include <optional>
#include <thread>

#include "tests/contract/fault_call.h"
#include "tests/contract/leds/led_faults.h"
#include "tests/contract/leds/usb_led_backend.h"
#include "tests/contract/warm_up.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr int kAlways = 1000;

Deadline soon() {
  return SteadyClock().in(Duration::of(2));
}

void inject(FadecandyBackend& backend, const std::string& fault) {
  FadecandyFirmware& f = backend.firmware();
  backend.peer().with_firmware([&] {
    f.silent = fault == "silence" || fault == "unplugged while waiting" ||
               fault == "switched off meanwhile";
    f.mute = fault == "requests unanswered";
    f.loses_frames = fault == "frame lost";
    f.stops_counting = fault == "stops counting";
    f.stalls = fault == "stalls again and again" ? kAlways : 0;
    f.errors = fault == "bus error" ? kAlways : 0;
    f.counter_bytes = fault == "counter of two bytes" ? 2 : 4;
    f.late_ns = fault == "late" ? 1'000'000'000 : 0;
    f.unplugs_after = fault == "unplugged in mid-frame"   ? 10
                      : fault == "unplugged in the table" ? 40
                                                          : -1;
  });
  if (fault == "unplugged") backend.unplug();
}

class FadecandyFaults : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() {
    warm_up(led_world());
    warm_up_usb();
  }
  FadecandyFaults() {
    settle_handles();
    resources_.emplace(0.2);
  }
  std::optional<MockResources> resources_;
};

void expect_not_opened(const FaultCase& fault) {
  const std::string what = fault.fault;
  FadecandyFirmwareOptions options;
  if (what == "old firmware") options.version = 0x0106;
  FadecandyBackend backend(options);
  FadecandyFirmwareOptions other_options;
  if (what == "two, and no serial") other_options.serial = "SIMFADECANDY0002";
  FadecandyFirmware other(backend.ceiling(), other_options);
  std::unique_ptr<UsbDevicePeer> second;
  FadecandySettings settings = odd_fadecandy();
  if (what == "not there") backend.unplug();
  if (what == "unknown serial") settings.usb_serial = "none";
  if (what.starts_with("two")) second = std::make_unique<UsbDevicePeer>(mock_bed(), other, "2");
  if (what == "two with one serial") settings.usb_serial = other_options.serial;
  if (what == "in use") backend.leds();
  inject(backend, what);
  std::optional<AsNobody> nobody;
  if (what == "not permitted") {
    backend.peer().forbid();
    nobody.emplace();
  }
  expect_fault(fault, [&](const Deadline&) { Fadecandy{settings}; });
  nobody.reset();
  EXPECT_EQ(backend.light(), 0);
}

TEST_P(FadecandyFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, after = fault.after;
  if (std::string(fault.state) == "opening") {
    if (what == "not permitted") resources_.reset();  // umockdev leaves handles of opens that fail
    expect_not_opened(fault);
    return;
  }
  FadecandyBackend backend;
  LedArray& leds = backend.leds();
  leds.set_all(0.5, soon());
  ASSERT_TRUE(backend.shows(0.5));
  inject(backend, what);
  std::jthread hand;
  if (what == "unplugged while waiting" || what == "switched off meanwhile") {
    hand = std::jthread([&] {
      SteadyClock().wait_until(SteadyClock().in(Duration::of(0.1)).at_ns);
      if (what == "unplugged while waiting")
        backend.unplug();
      else
        leds.all_off();
    });
  }
  expect_fault(fault, [&](const Deadline& d) {
    if (what == "more light than allowed")
      leds.set_all(0.8, d);
    else
      leds.set_all(0.2, what == "no time left" ? Deadline{SteadyClock().now_ns()} : d);
  });
  if (hand.joinable()) hand.join();
  if (after == "gone") {
    EXPECT_EQ(kind_of([&] { leds.set_all(0.2, soon()); }), Kind::kDisconnected);
    EXPECT_NEAR(backend.light(), 0.5, 0.01) << "half a frame";
    return;
  }
  if (after == "as before") {
    EXPECT_NEAR(backend.light(), 0.5, 0.01) << "half a frame";
  }
  inject(backend, "");
  if (after == "dark") {
    leds.all_off();
    EXPECT_TRUE(backend.shows(0));
  }
  leds.set_all(0.2, soon());
  EXPECT_TRUE(backend.shows(0.2)) << "it works again when the fault is over";
  backend.close();
  EXPECT_TRUE(backend.shows(0));
}

INSTANTIATE_TEST_SUITE_P(Leds, FadecandyFaults, ::testing::ValuesIn(kFadecandyFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class FadecandyOddities : public FadecandyFaults {};

TEST_F(FadecandyOddities, OneStallIsClearedAndTheWholeFrameSentAgain) {
  FadecandyBackend backend;
  backend.leds().set_all(0.5, soon());
  backend.peer().with_firmware([&] { backend.firmware().stalls = 1; });
  backend.leds().set_all(0.2, soon());
  EXPECT_TRUE(backend.shows(0.2));
  backend.peer().with_firmware([&] { backend.firmware().stalls = 1; });
  backend.leds().all_off();
  EXPECT_TRUE(backend.shows(0));
}

TEST_F(FadecandyOddities, ItsCounterMayWrap) {
  FadecandyFirmwareOptions options;
  options.first_frame = 0xfffffffd;
  FadecandyBackend backend(options);
  for (const double drive : {0.1, 0.2, 0.3, 0.4, 0.5}) {
    backend.leds().set_all(drive, soon());
    EXPECT_TRUE(backend.shows(drive));
  }
  backend.peer().with_firmware([&] { EXPECT_LT(backend.firmware().frames(), 10U); });
}

TEST_F(FadecandyOddities, StopsWithinFiftyMilliseconds) {
  FadecandyBackend backend;
  backend.leds().set_all(0.5, soon());
  inject(backend, "silence");
  std::stop_source source;
  std::jthread hand([&] {
    SteadyClock().wait_until(SteadyClock().in(Duration::of(0.05)).at_ns);
    source.request_stop();
  });
  const Nanoseconds start = SteadyClock().now_ns();
  EXPECT_THROW(backend.leds().set_all(0.1, {soon().at_ns, source.get_token()}), Cancelled);
  EXPECT_LT(SteadyClock().now_ns() - start, 150'000'000);
  EXPECT_NEAR(backend.light(), 0.5, 0.01);
  inject(backend, "");
}

TEST_F(FadecandyOddities, BackUnderAnotherPathItIsFoundByItsSerial) {
  FadecandyBackend backend;
  const std::string before = backend.leds().identity().address;
  backend.unplug();
  EXPECT_THAT(list_fadecandies(), ::testing::IsEmpty());
  FadecandyFirmware firmware(backend.ceiling());
  const UsbDevicePeer again(mock_bed(), firmware, "4.2");
  FadecandySettings settings = odd_fadecandy();
  settings.usb_serial = "SIMFADECANDY0001";
  Fadecandy leds(settings);
  EXPECT_NE(leds.identity().address, before);
  leds.set_all(0.3, soon());
  EXPECT_TRUE(backend.shows(0.3));
}

TEST_F(FadecandyOddities, TheRightOneOfTwoIsTaken) {
  FadecandyBackend backend;
  FadecandyFirmwareOptions options;
  options.serial = "B";
  options.model = "Gr\xfcn\x1b[2J";
  FadecandyFirmware firmware(backend.ceiling(), options);
  const UsbDevicePeer second(mock_bed(), firmware, "2");
  FadecandySettings settings = odd_fadecandy();
  settings.usb_serial = "B";
  const Fadecandy leds(settings);
  EXPECT_EQ(leds.identity().serial, "B");
  EXPECT_EQ(leds.identity().model, "Gr?n?[2J") << "nothing that a terminal would obey";
  EXPECT_EQ(leds.identity().firmware, "1.07");
  const std::vector<UsbFound> found = list_fadecandies();
  ASSERT_EQ(found.size(), 2U);
  for (const UsbFound& f : found) EXPECT_EQ(f.trouble.empty(), f.serial != "B") << f.trouble;
}

TEST_F(FadecandyOddities, EveryLedHangsWhereTheMappingSays) {
  FadecandyBackend backend;
  for (const int led : {0, 15, 16, 100, 128, 255}) {
    LedFrame frame{cv::Mat3f::zeros(16, 16)};
    frame.drive(led / 16, led % 16) = {1, 0, 0.25F};
    backend.leds().set_frame(frame, soon());
    EXPECT_TRUE(backend.shows(1.25 / 768, 1e-4));
    backend.peer().with_firmware([&] {
      const auto& light = backend.ceiling().light();
      int lit = 0;
      for (const auto& rgb : light) lit += rgb[0] + rgb[1] + rgb[2] > 0;
      EXPECT_EQ(lit, 1) << led;
      EXPECT_NEAR(light[static_cast<std::size_t>(led)][0], 1, 1e-4);
      EXPECT_NEAR(light[static_cast<std::size_t>(led)][2], 0.25, 0.005);
    });
  }
}

TEST_F(FadecandyOddities, ConfiguresDitheringAndFading) {
  for (const bool dither : {false, true})
    for (const bool fade : {false, true}) {
      FadecandyBackend backend;
      FadecandySettings settings = odd_fadecandy();
      settings.dither = dither;
      settings.interpolate = fade;
      const Fadecandy leds(settings);
      backend.peer().with_firmware([&] {
        EXPECT_EQ(backend.firmware().configuration(), (dither ? 0 : 1) | (fade ? 0 : 2));
      });
    }
}

}  // namespace
}  // namespace wheatstone
