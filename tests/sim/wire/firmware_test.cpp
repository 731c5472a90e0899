// Emulated firmware against what the reference (gantry_and_rotary.md) saw, in simulated time.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "sim/wire/arduino_gantry_firmware.h"
#include "sim/wire/grbl_firmware.h"
#include "sim/wire/jeti_firmware.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Talks to a firmware and lets its time pass.
template <class Firmware>
struct Bench {
  explicit Bench(Firmware f = Firmware()) : firmware(std::move(f)) {}
  std::string say(const std::string& bytes) {
    firmware.receive(bytes, now);
    return firmware.run(now);
  }
  std::string wait(double seconds) {
    std::string out;
    const Nanoseconds end = now + static_cast<Nanoseconds>(seconds * 1e9);
    while (firmware.next_event() <= end) {
      now = std::max(now, firmware.next_event());
      out += firmware.run(now);
    }
    now = end;
    return out + firmware.run(now);
  }
  /// Seconds until it says something.
  double until_it_speaks() {
    const Nanoseconds start = now;
    while (firmware.next_event() != SerialFirmware::kNever) {
      now = std::max(now, firmware.next_event());
      if (heard = firmware.run(now); !heard.empty()) break;
    }
    return static_cast<double>(now - start) * 1e-9;
  }
  Firmware firmware;
  Nanoseconds now = 0;
  std::string heard;
};

using Sketch = Bench<ArduinoGantryFirmware>;

Sketch homed() {
  Sketch sketch(ArduinoGantryFirmware({27000, true}, {}));
  EXPECT_EQ(sketch.say("0"), "") << "silent and deaf while it homes";
  EXPECT_EQ(sketch.wait(2 + 32.4), "");
  EXPECT_EQ(sketch.say("0"), "0\r\n");
  return sketch;
}

TEST(ArduinoGantryFirmware, TakesItsTimeAsMeasured) {
  Sketch sketch = homed();
  EXPECT_EQ(sketch.say("m10"), "");
  EXPECT_NEAR(sketch.until_it_speaks(), 4.31, 0.1);
  EXPECT_EQ(sketch.heard, "End\r\n");
  EXPECT_EQ(sketch.say("0"), "10\r\n");
  sketch.say("m10");
  EXPECT_NEAR(sketch.until_it_speaks(), 1.01, 0.02) << "when it is already there";
}

TEST(ArduinoGantryFirmware, TakesAllBytesOfASecondForDigits) {
  Sketch sketch = homed();
  sketch.say("m3");
  sketch.wait(0.3);
  sketch.say("0");
  sketch.wait(60);
  EXPECT_EQ(sketch.say("0"), "30\r\n");
  sketch.say("m7abc");
  sketch.wait(60);
  EXPECT_EQ(sketch.say("0"), "7\r\n");
  sketch.say("m");
  sketch.wait(60);
  EXPECT_EQ(sketch.say("0"), "0\r\n") << "a bare m drives home";
}

TEST(ArduinoGantryFirmware, WrapsAt16Bits) {
  Sketch sketch = homed();
  sketch.say("m125");
  EXPECT_NEAR(sketch.until_it_speaks(), 41, 2);
  EXPECT_EQ(sketch.say("0"), "-117\r\n");
  EXPECT_EQ(sketch.firmware.carriage_pulses(), 0) << "against the stop";
}

TEST(ArduinoGantryFirmware, RunsFreelyToItsEnds) {
  Sketch sketch = homed();
  EXPECT_EQ(sketch.say("1"), "");
  sketch.wait(5);
  const std::string place = sketch.say("0");
  EXPECT_NEAR(std::stoi(place), 5 / 0.0012 / 270, 1);
  sketch.say("1");
  sketch.wait(100);
  EXPECT_EQ(sketch.say("0"), "100\r\n");
}

TEST(ArduinoGantryFirmware, DoesNotSeeLostSteps) {
  Sketch sketch = homed();
  sketch.firmware.lose_steps(500);
  sketch.say("m50");
  sketch.wait(60);
  EXPECT_EQ(sketch.say("0"), "50\r\n");
  EXPECT_EQ(sketch.firmware.carriage_pulses(), 13000);
  sketch.say("r");
  sketch.wait(60);
  sketch.say("f");
  sketch.wait(10);
  EXPECT_EQ(sketch.firmware.carriage_pulses(), 270) << "after homing again";
}

TEST(ArduinoGantryFirmware, SurvivesAnyBytes) {
  RandomStream random(9, 0);
  Sketch sketch = homed();
  for (int i = 0; i < 1'000'000; ++i) {
    sketch.say(std::string(1, "0012mxfbr58-\r\n\xff"[random.next() % 16]));
    if (random.uniform() < 0.05) sketch.wait(random.uniform() * 20);
    ASSERT_GE(sketch.firmware.carriage_pulses(), 0);
    ASSERT_LE(sketch.firmware.carriage_pulses(), ArduinoGantryFirmware::kFullTravel);
  }
}

using Controller = Bench<GrblFirmware>;

TEST(GrblFirmware, StartsLockedAndHomes) {
  Controller grbl;
  EXPECT_THAT(grbl.wait(0), HasSubstr("Grbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]"));
  EXPECT_EQ(grbl.say("G1 X-5 F100\n"), "error:9\r\n");
  EXPECT_EQ(grbl.say("$H\n"), "");
  EXPECT_EQ(grbl.say("?"), "") << "no answer while it homes";
  EXPECT_EQ(grbl.wait(60), "ok\r\n");
  EXPECT_THAT(grbl.say("?"), HasSubstr("<Idle|MPos:-1.000,-1.000,0.000|"));
}

Controller ready() {
  Controller grbl;
  grbl.say("$H\n");
  grbl.wait(60);
  return grbl;
}

TEST(GrblFirmware, OkMeansPlannedAndADwellWaitsForTheEnd) {
  Controller grbl = ready();
  EXPECT_EQ(grbl.say("G90 G21 G53 G1 X-83.500 F3000\n"), "ok\r\n");
  EXPECT_THAT(grbl.say("?"), HasSubstr("<Run|"));
  EXPECT_EQ(grbl.say("G4 P0.01\n"), "");
  EXPECT_NEAR(grbl.until_it_speaks(), 82.5 / 50 + 50.0 / 500, 0.2);
  EXPECT_EQ(grbl.heard, "ok\r\n");
  EXPECT_THAT(grbl.say("?"), HasSubstr("<Idle|MPos:-83.500,"));
}

TEST(GrblFirmware, SoftLimitAlarmAnswersNothingButAReset) {
  Controller grbl = ready();
  EXPECT_THAT(grbl.say("G1 X10 F100\n"), HasSubstr("ALARM:2\r\n[MSG:Reset to continue]"));
  EXPECT_EQ(grbl.say("$$\n"), "");
  EXPECT_THAT(grbl.say("\x18"), HasSubstr("Grbl 1.1h"));
  EXPECT_EQ(grbl.say("G1 X-5 F100\n"), "error:9\r\n") << "locked";
  EXPECT_THAT(grbl.say("$X\n"), HasSubstr("ok"));
  EXPECT_EQ(grbl.say("G1 X-5 F100\n"), "ok\r\n");
}

TEST(GrblFirmware, HoldKeepsThePositionAResetInMotionLosesIt) {
  Controller grbl = ready();
  grbl.say("G53 G1 X-100 F3000\n");
  grbl.wait(1);
  grbl.say("!");
  EXPECT_THAT(grbl.say("?"), HasSubstr("<Hold:0|"));
  EXPECT_THAT(grbl.say("\x18"), Not(HasSubstr("ALARM")));
  EXPECT_THAT(grbl.say("?"), HasSubstr("<Idle|"));
  grbl.say("G53 G1 X-100 F3000\n");
  grbl.wait(0.3);
  EXPECT_THAT(grbl.say("\x18"), HasSubstr("ALARM:3"));
}

TEST(GrblFirmware, AnswersErrorsByNumber) {
  Controller grbl = ready();
  EXPECT_EQ(grbl.say("hello\n"), "error:2\r\n");
  EXPECT_EQ(grbl.say("5\n"), "error:1\r\n");
  EXPECT_EQ(grbl.say("$nonsense\n"), "error:3\r\n");
  EXPECT_EQ(grbl.say("G1 X-5\n"), "error:22\r\n");
  EXPECT_EQ(grbl.say("G2 X-5 F1\n"), "error:20\r\n");
  EXPECT_EQ(grbl.say("G0 G1 X-5 F1\n"), "error:24\r\n");
  EXPECT_EQ(grbl.say(std::string(100, '0') + "\n"), "error:11\r\n");
  EXPECT_THAT(grbl.say("$$\n"), HasSubstr("$100=160.000\r\n"));
}

TEST(GrblFirmware, SurvivesAnyBytes) {
  RandomStream random(10, 0);
  Controller grbl;
  const std::string alphabet = "G0194XYFP$HJ=?!~\x18\x85\n\r.-5 (;)\xff";
  std::size_t longest = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    longest = std::max(longest,
                       grbl.say(std::string(1, alphabet[random.next() % alphabet.size()])).size());
    if (random.uniform() < 0.02) grbl.wait(random.uniform() * 5);
  }
  EXPECT_LT(longest, 20'000U);
}

struct JetiBench : World, Bench<JetiFirmware> {
  JetiBench() : World("card", 0.02, 7), Bench<JetiFirmware>(JetiFirmware(*this)) {
    light.led_drive = 0.5;
  }
};

TEST(JetiFirmware, TakesUniqueStemsInAnyCase) {
  JetiBench jeti;
  EXPECT_EQ(jeti.say("*IDN?\r"), "JETI_SB1211\r");
  EXPECT_EQ(jeti.say("*contr:laser 1\r"), "\x06");
  EXPECT_EQ(jeti.say("*CONTrol:LASer?\r"), "laser: 1\r");
  EXPECT_EQ(jeti.say("*configure:wrange 380 780 1\r"), "\x06");
  for (const char* wrong : {"*conf:f 6\r", "*conf:cyc 1\r", "idn?\r", "*idn\r", "*\r", "\r"}) {
    EXPECT_EQ(jeti.say(wrong), "\x15") << wrong;
    EXPECT_EQ(jeti.say("*stat:err?\r"), "Error Code: 4 \r");
  }
  EXPECT_EQ(jeti.say("*conf:maxtin long\r"), "\x15");
  EXPECT_EQ(jeti.say("*stat:err?\r"), "Error Code: 8 \r");
}

TEST(JetiFirmware, MeasuresInItsTimeAndCanBeAborted) {
  JetiBench jeti;
  EXPECT_EQ(jeti.say("*init\r"), "\x06");
  EXPECT_EQ(jeti.say("*fetch:XYZ\r"), "") << "it listens to ESC only";
  EXPECT_NEAR(jeti.until_it_speaks(), 3.6, 0.2);
  EXPECT_EQ(jeti.heard, "\x07");
  const std::string spectrum = jeti.say("*fetch:sprad\r");
  EXPECT_EQ(std::count(spectrum.begin(), spectrum.end(), '\r'), 2 + 401);
  EXPECT_EQ(jeti.say("*init\r"), "\x06");
  EXPECT_EQ(jeti.say("\x1b"), "\x15");
  EXPECT_EQ(jeti.say("*stat:err?\r"), "Error Code: 147 \r");
  EXPECT_EQ(jeti.wait(100), "");
}

TEST(JetiFirmware, SurvivesAnyBytes) {
  RandomStream random(10, 1);
  JetiBench jeti;
  const std::string alphabet =
      "*:? \r\x1b"
      "conftrlsemaiupdxyz019.-\xff";
  std::size_t longest = 0;
  for (int i = 0; i < 1'000'000; ++i)
    longest = std::max(longest,
                       jeti.say(std::string(1, alphabet[random.next() % alphabet.size()])).size());
  EXPECT_LT(longest, 20'000U);
}

}  // namespace
}  // namespace wheatstone
