// What every light sensor promises, whatever it is made of; and every line of the table of their
// faults, carried out.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <thread>

#include "core/error.h"
#include "hardware/serial/photodiode.h"
#include "sim/light_sensor.h"
#include "sim/wire/photodiode_firmware.h"
#include "sim/wire/pty_peer.h"
#include "sim/world.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/light_sensor_faults.h"
#include "tests/contract/resources.h"
#include "tests/contract/warm_up.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr DisplayId kDisplay{Eye::kLeft, Plane::kNear};

/// White on both modulators.
void show_white(World& world) {
  const PanelModel& m = world.model(kDisplay);
  PanelDrive& drive = world.panel_drives[static_cast<std::size_t>(index_of(kDisplay))];
  drive.lcd.codes = cv::Mat(m.lcd_height_px, m.lcd_width_px, CV_8UC3, cv::Scalar::all(255));
  drive.projector.codes =
      cv::Mat(m.projector_height_px, m.projector_width_px, CV_8UC1, cv::Scalar::all(255));
}

class Backend {
 public:
  virtual ~Backend() = default;
  virtual LightSensor& sensor() = 0;
  virtual Clock& clock() = 0;
  virtual void unplug() = 0;
  World& world() { return world_; }
  /// White on the display, while nobody records it.
  virtual void light_up() { show_white(world_); }

 protected:
  World world_{"card", 0.02, 7};
};

class TwinBackend final : public Backend {
 public:
  explicit TwinBackend(double gain = 1) : sensor_(world_, kDisplay, gain) {}
  LightSensor& sensor() override { return sensor_; }
  Clock& clock() override { return world_.clock; }
  void unplug() override { world_.faults.arm("light sensor", kDisconnected); }

 private:
  SimulatedLightSensor sensor_;
};

class SerialBackend final : public Backend {
 public:
  explicit SerialBackend(double gain = 1, std::uint32_t first_us = 0)
      : firmware_(world_, kDisplay, gain) {
    peer_.with_firmware([&] { firmware_.first_us = first_us; });
  }
  LightSensor& sensor() override {
    if (!sensor_) sensor_ = std::make_unique<SerialPhotodiode>(settings());
    return *sensor_;
  }
  SerialPhotodiodeSettings settings() const { return {peer_.path(), 921600, "SIM-PHOTODIODE"}; }
  Clock& clock() override { return clock_; }
  void unplug() override { peer_.unplug(); }
  void light_up() override {
    peer_.with_firmware([&] { show_white(world_); });
  }
  PtyPeer& peer() { return peer_; }
  PhotodiodeFirmware& firmware() { return firmware_; }
  void close() { sensor_.reset(); }

 private:
  SteadyClock clock_;
  PhotodiodeFirmware firmware_;
  PtyPeer peer_{firmware_};
  std::unique_ptr<SerialPhotodiode> sensor_;
};

double mean(const LightTrace& trace) {
  return std::accumulate(trace.levels.begin(), trace.levels.end(), 0.0) /
         static_cast<double>(trace.levels.size());
}

struct Maker {
  const char* name;
  std::unique_ptr<Backend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class LightSensorContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { warm_up(); }
  LightTrace record(double duration_s) {
    return backend_->sensor().record(Duration::of(duration_s),
                                     backend_->clock().in(Duration::of(duration_s + 2)));
  }

  ResourceWatch resources_{1.0};  // a world takes its time
  std::unique_ptr<Backend> backend_ = GetParam().make();
};

TEST_P(LightSensorContract, SaysWhoItIs) {
  EXPECT_FALSE(backend_->sensor().identity().driver.empty());
}

TEST_P(LightSensorContract, RecordsAsLongAsItIsAsked) {
  for (const double duration_s : {0.0001, 0.0064, 0.3}) {
    const Nanoseconds before = backend_->clock().now_ns();
    const LightTrace trace = record(duration_s);
    ASSERT_GT(trace.samples_per_s, 0);
    EXPECT_NEAR(static_cast<double>(trace.levels.size()), duration_s * trace.samples_per_s, 0.5);
    // Within half a round trip.
    EXPECT_GT(trace.start_ns, before - 5'000'000);
    EXPECT_LE(trace.start_ns + static_cast<Nanoseconds>(1e9 * duration_s),
              backend_->clock().now_ns() + 5'000'000);
  }
}

TEST_P(LightSensorContract, LevelsAreLinearInLight) {
  const double dark = mean(record(0.05));
  backend_->light_up();
  const LightTrace lit = record(0.05);
  EXPECT_LT(dark, 0.01);
  EXPECT_GT(mean(lit), 0.2);
  for (const float level : lit.levels) {
    EXPECT_GE(level, 0);
    EXPECT_LT(level, 1);
  }
}

TEST_P(LightSensorContract, RefusesRecordingsThatCannotBe) {
  for (const double duration_s : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(kind_of([&] {
                backend_->sensor().record(Duration::of(duration_s),
                                          backend_->clock().in(Duration::of(1)));
              }),
              kOutOfRange)
        << duration_s;
}

TEST_P(LightSensorContract, KeepsDeadlinesAndStopsOnRequest) {
  LightSensor& sensor = backend_->sensor();
  const auto in = [&](double s) { return backend_->clock().in(Duration::of(s)); };
  EXPECT_EQ(kind_of([&] { sensor.record(Duration::of(5), in(0.2)); }), kTimeout);
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(sensor.record(Duration::of(0.05), {in(1).at_ns, asked.get_token()}), Cancelled);
  EXPECT_EQ(record(0.05).levels.size(), 500U) << "it works after both";
}

TEST_P(LightSensorContract, StaysGoneOnceItIsGone) {
  record(0.01);
  backend_->unplug();
  EXPECT_EQ(kind_of([&] { record(0.01); }), kDisconnected);
  EXPECT_EQ(kind_of([&] { record(0.01); }), kDisconnected);
}

template <class B>
std::unique_ptr<Backend> make() {
  return std::make_unique<B>();
}
const Maker kMakers[] = {{"Twin", make<TwinBackend>}, {"Serial", make<SerialBackend>}};

INSTANTIATE_TEST_SUITE_P(Sensors, LightSensorContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

class FaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up(); }
  ResourceWatch resources_{1.0};
};

class PhotodiodeFaults : public FaultTest {};

void inject(SerialBackend& backend, const std::string& fault) {
  PtyPeer& peer = backend.peer();
  PhotodiodeFirmware& f = backend.firmware();
  if (fault == "silence") peer.silence(true);
  if (fault == "unplugged") peer.unplug();
  if (fault == "half a block") peer.cut_after(200);
  if (fault == "garbage") peer.spoil([](const std::string&) { return "TIME one two\n"; });
  if (fault == "over-long line")
    peer.spoil([](const std::string&) { return std::string(999, '0'); });
  if (fault == "not ASCII") peer.spoil([](const std::string&) { return "\xc3\x28\xff\xfe\n"; });
  if (fault == "flipped bit")
    peer.spoil([](std::string sent) {
      if (sent.size() > 100) sent.back() ^= 4;  // no answer is so long
      return sent;
    });
  peer.with_firmware([&] {
    if (fault == "another device") f.identity = "Grbl 1.1h ['$' for help]";
    if (fault == "another protocol") f.identity = "PHOTODIODE/2 SIM-PHOTODIODE 10000";
    if (fault == "another serial") f.identity = "PHOTODIODE/1 SOMEBODY 10000";
    if (fault == "rate of nothing") f.identity = "PHOTODIODE/1 SIM-PHOTODIODE 0";
    if (fault == "rate that is none") f.identity = "PHOTODIODE/1 SIM-PHOTODIODE ten";
    if (fault == "refusal") f.refusal = "ERROR too hot";
    if (fault == "answer to an earlier question") f.refuse_time = true;
    if (fault == "lost block") f.lose_block = 5;
    if (fault == "stall") f.stall_after = 5;
    if (fault == "clock step") f.step_clock_us = 20'000;
    if (fault == "clock set back") f.step_clock_us = -1'000'000'000;
    if (fault == "too many samples") f.extra_samples = 10;
  });
}

void mend(SerialBackend& backend) {
  if (backend.peer().path().empty()) {
    backend.close();
    backend.peer().plug_in();  // under another path
  }
  backend.peer().silence(false);
  backend.peer().spoil({});
  backend.peer().with_firmware([&] {
    PhotodiodeFirmware& f = backend.firmware();
    f.refusal.clear();
    f.refuse_time = false;
    f.lose_block = f.stall_after = -1;
    f.extra_samples = f.step_clock_us = 0;
  });
}

TEST_P(PhotodiodeFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  SerialBackend backend(what == "saturated" ? 100 : 1);
  if (state == "opening") {
    const TemporaryFolder folder;
    SerialPhotodiodeSettings settings = backend.settings();
    std::unique_ptr<SerialPort> other;
    if (what == "in use")
      other = std::make_unique<SerialPort>("another program", settings.line, 921600);
    if (what == "not there") settings.line = folder.path / "none";
    if (what == "no serial line") {
      settings.line = folder.path / "file";
      std::ofstream(settings.line) << "x";
    }
    inject(backend, what);
    expect_fault(fault, [&](const Deadline&) { SerialPhotodiode{settings}; });
    return;
  }
  LightSensor& sensor = backend.sensor();
  const auto later = [] { return SteadyClock().in(Duration::of(2)); };
  sensor.record(Duration::of(0.01), later());
  if (what == "saturated") backend.light_up();
  std::jthread hand;
  if (state == "recording" && what == "unplugged")
    hand = std::jthread([&](const std::stop_token& stop) {
      bool recording = false;
      while (!recording && !stop.stop_requested()) {
        SteadyClock().wait_until(SteadyClock().now_ns() + 5'000'000);
        backend.peer().with_firmware([&] { recording = backend.firmware().recording(); });
      }
      backend.unplug();
    });
  else
    inject(backend, what);
  expect_fault(fault, [&](const Deadline& d) {
    sensor.record(Duration::of(what == "too long" ? 1e6 : 0.1), d);
  });
  if (hand.joinable()) hand.join();
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { sensor.record(Duration::of(0.01), later()); }), Kind::kDisconnected);
  }
  mend(backend);
  if (what != "saturated") {
    EXPECT_EQ(backend.sensor().record(Duration::of(0.1), later()).levels.size(), 1000U);
  }
}

INSTANTIATE_TEST_SUITE_P(Sensors, PhotodiodeFaults, ::testing::ValuesIn(kPhotodiodeFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedLightSensorFaults : public FaultTest {};

TEST_P(SimulatedLightSensorFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const bool saturated = fault.error == kTooBright;
  TwinBackend backend(saturated ? 100 : 1);
  const auto record = [&] {
    backend.sensor().record(Duration::of(0.1), backend.clock().in(Duration::of(1)));
  };
  if (saturated)
    backend.light_up();
  else
    arm(backend.world().faults, "light sensor", fault);
  expect_fault(fault, [&](const Deadline&) { record(); });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of(record), kDisconnected);
    backend.world().faults.reconnect("light sensor");
  }
  if (!saturated) record();
}

INSTANTIATE_TEST_SUITE_P(Sensors, SimulatedLightSensorFaults,
                         ::testing::ValuesIn(kSimulatedLightSensorFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class LightSensorOddities : public FaultTest {};

TEST_F(LightSensorOddities, MicrosecondsOfTheDeviceMayWrap) {
  SerialBackend backend(1, 0xffffffff - 5'000);  // 5 ms before it does
  for (int i = 0; i < 3; ++i) {
    const Nanoseconds before = SteadyClock().now_ns();
    const LightTrace trace =
        backend.sensor().record(Duration::of(0.01), SteadyClock().in(Duration::of(2)));
    EXPECT_GT(trace.start_ns, before - 5'000'000);
    EXPECT_LT(trace.start_ns, SteadyClock().now_ns());
  }
}

TEST_F(LightSensorOddities, BlockNumbersWrap) {
  SerialBackend backend;
  const LightTrace trace =
      backend.sensor().record(Duration::of(2), SteadyClock().in(Duration::of(4)));
  EXPECT_EQ(trace.levels.size(), 20'000U) << "313 blocks";
}

TEST_F(LightSensorOddities, WhatItSeesIsWhatTheTwinSees) {
  SerialBackend wire;
  TwinBackend twin;
  wire.light_up();
  twin.light_up();
  const auto levels = [](Backend& b) {
    return b.sensor().record(Duration::of(0.05), b.clock().in(Duration::of(2))).levels;
  };
  EXPECT_EQ(levels(wire), levels(twin));
}

}  // namespace
}  // namespace wheatstone
