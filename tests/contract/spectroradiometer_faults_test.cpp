// Every line of the tables of the spectroradiometers' faults, carried out.

#include <gmock/gmock.h>
#include <termios.h>

#include <fcntl.h>
#include <unistd.h>

#include <thread>

#include "core/error.h"
#include "core/files.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/resources.h"
#include "tests/contract/spectroradiometer_backends.h"
#include "tests/contract/spectroradiometer_faults.h"

namespace wheatstone {
namespace {

Deadline later() {
  return SteadyClock().in(Duration::of(4));
}

class MeterFaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { MeterBackend::prepare(); }
  ResourceWatch resources_;
};

class JetiFaults : public MeterFaultTest {};

void inject(JetiMeter& backend, const std::string& fault) {
  PtyPeer& peer = backend.peer();
  JetiFirmware& f = backend.firmware();
  const auto always = [&](const char* answer) {
    peer.spoil([answer](const std::string&) { return answer; });
  };
  if (fault == "silence") peer.silence(true);
  if (fault == "unplugged") peer.unplug();
  if (fault == "not ASCII") always("\xc3\x28\xff\r");
  if (fault == "garbage") always("mhead: many\r");
  if (fault == "answer to an earlier command") always("laser: 0\r");
  if (fault == "half an answer") peer.cut_after(6);
  if (fault == "half a spectrum")
    peer.spoil([](std::string sent) {
      if (sent.size() > 500) sent.resize(300);  // no answer is so long
      return sent;
    });
  if (fault == "over-long line")
    peer.spoil([](const std::string&) { return std::string(999, '7'); });
  if (fault == "underexposed") backend.light(0);
  peer.with_firmware([&] {
    if (fault == "another device") f.name = "Grbl 1.1h ['$' for help]";
    if (fault == "another serial") f.number = 1;
    if (fault == "impossible wavelengths") f.first_nm = 900;
    if (fault == "refuses everything") f.answer_instead = "\x15";
    if (fault == "light stays on") f.laser_stuck = true;
    if (fault.starts_with("error ")) f.refuse_with = std::stoi(fault.substr(6));
    if (fault == "diffuser on") f.diffuser_on = true;
    if (fault == "stall") f.never_done = true;
    if (fault == "lost lines") f.lose_lines_of = 1000;
    if (fault == "another luminance") f.xyz_factor = 1.02;
  });
}

void mend(JetiMeter& backend) {
  if (backend.peer().path().empty()) {
    backend.close();
    backend.peer().plug_in();  // under another path
  }
  backend.peer().silence(false);
  backend.peer().spoil({});
  backend.light(0.5);
  backend.peer().with_firmware([&] {
    JetiFirmware& f = backend.firmware();
    f.laser_stuck = f.diffuser_on = f.never_done = false;
    f.refuse_with = f.lose_lines_of = 0;
    f.xyz_factor = 1;
  });
}

TEST_P(JetiFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  JetiMeter backend(what == "overexposed" ? 1e4 : 1);
  if (state == "opening") {
    const TemporaryFolder folder;
    JetiSettings settings = backend.settings();
    settings.answer = Duration::of(0.2);
    std::unique_ptr<SerialPort> other;
    if (what == "in use")
      other = std::make_unique<SerialPort>("another program", settings.line, 921600);
    if (what == "not there") settings.line = folder.path / "none";
    if (what == "no serial line") {
      settings.line = folder.path / "file";
      std::ofstream(settings.line) << "x";
    }
    inject(backend, what);
    expect_fault(fault, [&](const Deadline&) { Jeti{settings}; });
    return;
  }
  Jeti& meter = backend.meter();
  if (what == "underexposed") {
    Spectroradiometer::Settings settings;
    settings.longest_integration = Duration::of(5);
    meter.configure(settings, later());
  }
  if (what != "overexposed") meter.measure(later());
  std::jthread hand;
  if (state == "measuring" && what == "unplugged") {
    backend.peer().with_firmware([&] { backend.firmware().never_done = true; });
    hand = std::jthread([&](const std::stop_token& stop) {
      bool measuring = false;
      while (!measuring && !stop.stop_requested()) {
        SteadyClock().wait_until(SteadyClock().now_ns() + 5'000'000);
        backend.peer().with_firmware([&] { measuring = backend.firmware().measuring(); });
      }
      backend.unplug();
    });
  } else {
    inject(backend, what);
  }
  expect_fault(fault, [&](const Deadline& d) {
    if (state == "configuring") {
      Spectroradiometer::Settings settings;
      if (what == "too long") settings.longest_integration = Duration::of(61);
      meter.configure(settings, d);
    } else if (state == "aiming") {
      meter.aim(false, d);
    } else {
      meter.measure(d);
    }
  });
  if (hand.joinable()) hand.join();
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { meter.measure(later()); }), kDisconnected);
  }
  mend(backend);
  if (what == "overexposed") return;
  EXPECT_NEAR(backend.meter().measure(later()).xyz_cd_m2.y(), backend.truth_cd_m2(),
              0.02 * backend.truth_cd_m2());
  bool laser = true;
  backend.peer().with_firmware([&] { laser = backend.firmware().laser(); });
  EXPECT_FALSE(laser);
}

INSTANTIATE_TEST_SUITE_P(Meters, JetiFaults, ::testing::ValuesIn(kJetiFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SpotreadFaults : public MeterFaultTest {};

TEST_P(SpotreadFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  SpotreadMeter backend;
  if (state == "opening") {
    SpotreadSettings settings = backend.settings();
    if (what == "no such program") settings.program = "no-such-spotread";
    if (what == "may not be run")
      std::filesystem::permissions(backend.script(), std::filesystem::perms::owner_read);
    expect_fault(fault, [&](const Deadline&) { Spotread{settings}; });
    return;
  }
  Spotread& meter = backend.meter();
  const auto rewrite = [&](const char* file, const std::string& from, const std::string& to) {
    std::string text = read_text(backend.folder() / file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos);
    text.replace(at, from.size(), to);
    std::ofstream(backend.folder() / file) << text;
  };
  const std::filesystem::path elsewhere = backend.folder() / "elsewhere";
  if (what == "hangs") backend.trouble("exec sleep 77");
  if (what == "hangs with a child") backend.trouble("sleep 77 & sleep 78");
  if (what == "ends with 1") backend.trouble("echo 'Instrument initialisation failed'; exit 1");
  if (what == "killed") backend.trouble("kill -9 $$");
  if (what == "no XYZ") rewrite("output", "Result is", "Result was");
  if (what == "XYZ that is none") rewrite("output", "XYZ: ", "XYZ: nan ");
  if (what == "no spectrum") backend.trouble("cat output; exit 0");
  if (what == "half a spectrum") rewrite("reading.sp", "\nEND_DATA\n", "\n");
  if (what == "spectrum of two readings") rewrite("reading.sp", "SETS 1", "SETS 2");
  if (what == "spectrum without norm") rewrite("reading.sp", "\nSPECTRAL_NORM", "\nNORM");
  if (what == "not ASCII") rewrite("reading.sp", "BEGIN_DATA\n", "BEGIN_DATA\n\xc3\x28 ");
  if (what == "output without end") backend.trouble("yes");
  if (what == "another luminance") rewrite("output", "XYZ: ", "XYZ: 1");
  if (what == "program removed") std::filesystem::rename(backend.script(), elsewhere);
  const std::string message = expect_fault(fault, [&](const Deadline& d) {
    Spectroradiometer::Settings settings;
    settings.longest_integration = Duration::of(1);
    if (state == "configuring")
      meter.configure(settings, d);
    else if (state == "aiming")
      meter.aim(true, d);
    else
      meter.measure(d);
  });
  if (what == "ends with 1") {
    EXPECT_THAT(message, ::testing::HasSubstr("Instrument initialisation failed"));
  }
  if (what == "program removed") std::filesystem::rename(elsewhere, backend.script());
  backend.trouble("");
  backend.write_reading();
  EXPECT_NEAR(meter.measure(later()).xyz_cd_m2.y(), backend.truth_cd_m2(),
              0.02 * backend.truth_cd_m2());
}

INSTANTIATE_TEST_SUITE_P(Meters, SpotreadFaults, ::testing::ValuesIn(kSpotreadFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedMeterFaults : public MeterFaultTest {};

TEST_P(SimulatedMeterFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  TwinMeter backend(what == "overexposed" ? 1e4 : 1);
  const auto in = [&](double s) { return backend.clock().in(Duration::of(s)); };
  double patience_s = 200;
  if (what == "not enough time")
    patience_s = 1;
  else if (what == "underexposed")
    backend.light(0);
  else if (what != "overexposed")
    arm(backend.world().faults, "spectroradiometer", fault);
  expect_fault(fault, [&](const Deadline&) { backend.meter().measure(in(patience_s)); });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { backend.meter().measure(in(200)); }), kDisconnected);
    backend.world().faults.reconnect("spectroradiometer");
  }
  backend.light(0.5);
  if (what != "overexposed") backend.meter().measure(in(200));
}

INSTANTIATE_TEST_SUITE_P(Meters, SimulatedMeterFaults, ::testing::ValuesIn(kSimulatedMeterFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class JetiOddities : public MeterFaultTest {};

double measured(JetiMeter& backend) {
  return backend.meter().measure(later()).xyz_cd_m2.y();
}

TEST_F(JetiOddities, StrayEnquiriesDoNotMatter) {
  for (const int every : {1, 2, 7}) {
    JetiMeter backend;
    backend.peer().with_firmware([&] { backend.firmware().enq_every = every; });
    EXPECT_NEAR(measured(backend), backend.truth_cd_m2(), 0.02 * backend.truth_cd_m2());
  }
}

TEST_F(JetiOddities, OldFirmwareSaysItsVersionOnTwoLines) {
  JetiMeter backend;
  backend.peer().with_firmware([&] { backend.firmware().version = "1.49\rof 2010"; });
  EXPECT_EQ(backend.meter().identity().firmware, "1.49 of 2010");
  EXPECT_NEAR(measured(backend), backend.truth_cd_m2(), 0.02 * backend.truth_cd_m2());
}

TEST_F(JetiOddities, ASpectrumThatLostLinesIsAskedForAgain) {
  JetiMeter backend;
  backend.meter();
  backend.peer().with_firmware([&] { backend.firmware().lose_lines_of = 4; });
  EXPECT_NEAR(measured(backend), backend.truth_cd_m2(), 0.02 * backend.truth_cd_m2());
}

TEST_F(JetiOddities, FirmwareWithoutXyzGivesLuminanceAndChromaticity) {
  JetiMeter backend;
  backend.peer().with_firmware([&] { backend.firmware().has_xyz = false; });
  const SpectralReading r = backend.meter().measure(later());
  EXPECT_TRUE(agree(r.xyz_cd_m2, *r.device_xyz_cd_m2));
}

TEST_F(JetiOddities, UnitsCalibratedForTheVisibleOnlyAreReadThere) {
  JetiMeter backend;
  backend.peer().with_firmware([&] {
    backend.firmware().first_nm = 350;
    backend.firmware().last_nm = 1000;
    backend.firmware().calibrated_widely = false;
  });
  EXPECT_EQ(backend.meter().range().last_nm, 1000);
  EXPECT_NEAR(measured(backend), backend.truth_cd_m2(), 0.02 * backend.truth_cd_m2());
  EXPECT_EQ(backend.meter().range().first_nm, 380);
  EXPECT_EQ(backend.meter().range().last_nm, 780);
}

TEST_F(JetiOddities, TheFullRangeOfAWideUnitIsRead) {
  JetiMeter backend;
  backend.peer().with_firmware([&] {
    backend.firmware().first_nm = 350;
    backend.firmware().last_nm = 1000;
  });
  EXPECT_EQ(backend.meter().measure(later()).spectrum.values.size(), 651U);
}

TEST_F(JetiOddities, ItsSpeedIsFound) {
  JetiMeter backend;
  const std::string terminal = backend.peer().path();
  for (const speed_t speed : {B921600, B115200, B38400}) {
    backend.close();
    backend.peer().spoil([=](const std::string& sent) -> std::string {
      const int handle = ::open(terminal.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
      termios line{};
      ::tcgetattr(handle, &line);
      ::close(handle);
      return ::cfgetospeed(&line) == speed ? sent : "\xf8\x80\xf8";
    });
    JetiSettings settings = backend.settings();
    settings.baud = 0;
    settings.answer = Duration::of(0.15);
    Jeti meter(settings);
    EXPECT_GT(meter.measure(later()).xyz_cd_m2.y(), 0);
  }
}

TEST_F(JetiOddities, SettingsArriveAndTheAimingLightIsPutOut) {
  JetiMeter backend;
  Spectroradiometer::Settings settings;
  settings.longest_integration = Duration::of(2.5);
  settings.average = 4;
  settings.synchronise_to = Duration::of(1.0 / 60);
  backend.meter().configure(settings, later());
  backend.meter().aim(true, later());
  const JetiFirmware& f = backend.firmware();
  backend.peer().with_firmware([&] {
    EXPECT_EQ(f.longest_s(), 2.5);
    EXPECT_EQ(f.average(), 4);
    EXPECT_NEAR(f.period_s(), 1.0 / 60, 1e-6);
    EXPECT_TRUE(f.laser());
  });
  backend.meter().measure(later());
  backend.peer().with_firmware([&] { EXPECT_FALSE(f.laser()); });
  backend.meter().aim(true, later());
  backend.close();  // leaves it dark
  for (bool laser = true; laser;) backend.peer().with_firmware([&] { laser = f.laser(); });
}

TEST_F(JetiOddities, AMeasurementIsAborted) {
  JetiMeter backend;
  Jeti& meter = backend.meter();
  backend.peer().with_firmware([&] { backend.firmware().never_done = true; });
  std::jthread hand([&] {
    for (bool measuring = false; !measuring;) {
      SteadyClock().wait_until(SteadyClock().now_ns() + 2'000'000);
      backend.peer().with_firmware([&] { measuring = backend.firmware().measuring(); });
    }
    meter.abort();
  });
  EXPECT_THROW(meter.measure(later()), Cancelled);
  hand.join();
  backend.peer().with_firmware([&] {
    EXPECT_FALSE(backend.firmware().measuring());
    backend.firmware().never_done = false;
  });
  EXPECT_GT(measured(backend), 0);
}

TEST_F(JetiOddities, AKilledProgramsMeasurementIsEnded) {
  JetiMeter backend;
  backend.peer().with_firmware([&] { backend.firmware().never_done = true; });
  {
    SerialPort other("another program", backend.peer().path(), 921600);
    other.write("*init\r", later());
    other.read(later());
  }
  backend.peer().with_firmware([&] {
    ASSERT_TRUE(backend.firmware().measuring());
    backend.firmware().never_done = false;
  });
  EXPECT_GT(measured(backend), 0);
}

class SpotreadOddities : public MeterFaultTest {};

TEST_F(SpotreadOddities, IsAskedAsItsManualSays) {
  SpotreadMeter backend;
  backend.meter().measure(later());
  const std::string arguments = read_text(backend.folder() / "arguments");
  EXPECT_THAT(arguments, ::testing::StartsWith("-c 2 -e -x -O "));
}

TEST_F(SpotreadOddities, HasNeitherInputNorTerminal) {
  SpotreadMeter backend;
  backend.trouble("read -r line && exit 3; (: < /dev/tty) 2> /dev/null && exit 4");
  EXPECT_GT(backend.meter().measure(later()).xyz_cd_m2.y(), 0);
}

TEST_F(SpotreadOddities, AReadingIsAborted) {
  SpotreadMeter backend;
  backend.trouble("touch started; exec sleep 77");
  std::jthread hand([&] {
    while (!std::filesystem::exists(backend.folder() / "started"))
      SteadyClock().wait_until(SteadyClock().now_ns() + 2'000'000);
    backend.meter().abort();
  });
  EXPECT_THROW(backend.meter().measure(later()), Cancelled);
}

TEST_F(SpotreadOddities, ChildrenOfItsOwnDoNotOutliveIt) {
  SpotreadMeter backend;
  backend.trouble("sleep 77 & echo $! > child");
  EXPECT_GT(backend.meter().measure(later()).xyz_cd_m2.y(), 0) << "nor hold the call up";
  const std::string child = read_text(backend.folder() / "child");
  const std::filesystem::path process = "/proc/" + child.substr(0, child.find('\n'));
  const Deadline soon = later();
  const auto lives = [&] {
    if (!std::filesystem::exists(process)) return false;
    std::ifstream status(process / "status");
    std::string text((std::istreambuf_iterator<char>(status)), {});
    return !text.empty() && text.find("State:\tZ") == std::string::npos;
  };
  while (lives() && SteadyClock().now_ns() < soon.at_ns)
    SteadyClock().wait_until(SteadyClock().now_ns() + 5'000'000);
  EXPECT_FALSE(lives());
}

}  // namespace
}  // namespace wheatstone
