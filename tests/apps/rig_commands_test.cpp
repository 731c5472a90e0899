// doctor, jog, emulate and capture --rig, as a person runs them.

#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/drivers.h"
#include "apps/rig_source.h"
#include "core/files.h"
#include "hardware/transport/serial_port.h"
#include "program.h"
#include "sim/wire/grbl_firmware.h"
#include "sim/wire/jeti_firmware.h"
#include "sim/wire/pty_peer.h"

namespace wheatstone::apps {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pair;

const std::string kSafety = "[safety]\nluminance_limit_cd_m2 = 3000\n";
const std::string kSimulated = std::string(WHEATSTONE_SOURCE_DIR) + "/rigs/simulated.toml";

class RigCommands : public TemporaryFolder {
 protected:
  std::string rig_file(const std::string& body) {
    const std::string file = path("rig.toml");
    write_text_atomically(file,
                          "schema = \"wheatstone-rig/1\"\nname = \"test\"\n" + body + kSafety);
    return file;
  }
  std::string grbl_rig(const std::string& port) {
    return rig_file("[stage]\ndriver = \"grbl\"\nport = \"" + port +
                    "\"\ntravel_mm = 167\n[soft_limits]\nstage_mm = [1, 160]\n");
  }
};

TEST_F(RigCommands, EveryRigFileOfTheProjectReads) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(WHEATSTONE_SOURCE_DIR) / "rigs")) {
    EXPECT_NO_THROW(read_rig_file(entry.path(), all_drivers())) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 3);
}

TEST_F(RigCommands, DoctorFindsTheSimulatedRigInOrder) {
  const Outcome outcome = run_program({"doctor", "--rig", kSimulated, "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report.at("devices").size(), 10U + 9U) << "kinds of devices and displays";
  for (const auto& device : report.at("devices")) EXPECT_EQ(device.at("status"), "ok");
  EXPECT_THAT(run_program({"doctor", "--rig", kSimulated}).out,
              AllOf(HasSubstr("stage"), HasSubstr("camera"), HasSubstr("OpenGL")));
}

TEST_F(RigCommands, DoctorTellsWhichDisplaysTheTwinLacks) {
  const std::string twin = read_text(kSimulated), file = path("rig.toml");
  const auto status_of = [&](const std::string& from, const std::string& to) {
    std::string changed = twin;
    changed.replace(changed.find(from), from.size(), to);
    write_text_atomically(file, changed);
    const Outcome outcome = run_program({"doctor", "--rig", file, "--json"});
    EXPECT_EQ(outcome.status, 1) << to;
    std::map<std::string, std::string> wrong;
    const auto report = nlohmann::json::parse(outcome.out);
    for (const auto& device : report.at("devices"))
      if (device.at("status") != "ok") wrong[device.at("role")] = device.at("problem");
    return wrong;
  };
  EXPECT_THAT(status_of("serial = 103", "serial = 999"),
              ElementsAre(Pair("output right_near_lcd", HasSubstr("identity"))));
  EXPECT_THAT(status_of("connector = \"SIM-2\"", "connector = \"SIM-10\""),
              ElementsAre(Pair("output left_near_projector", HasSubstr("SIM-10"))));
  EXPECT_THAT(status_of("width_px = 1920", "width_px = 3840"),
              ElementsAre(Pair("output operator", HasSubstr("mode"))));
}

TEST_F(RigCommands, DoctorNamesWhatIsWrongWithItsRemedy) {
  expect_refused(run_program({"doctor", "--rig", path("none.toml")}), {"none.toml"});
  const Outcome missing = run_program({"doctor", "--rig", grbl_rig(path("tty"))});
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.out, AllOf(HasSubstr("not found"), HasSubstr("plug it in")));

  GrblFirmware::Options old;
  old.version = "0.9j";
  GrblFirmware firmware(old, {});
  const PtyPeer peer(firmware, path("grbl"), 20);
  const Outcome wrong = run_program({"doctor", "--rig", grbl_rig(path("grbl"))});
  EXPECT_EQ(wrong.status, 1);
  EXPECT_THAT(wrong.out, AllOf(HasSubstr("Grbl 0.9j"), HasSubstr("install GRBL 1.1")));
}

TEST_F(RigCommands, JogMovesARealDriverAndGuardsItsLimits) {
  GrblFirmware firmware;
  PtyPeer peer(firmware, path("grbl"), 20);
  Surroundings typing;
  typing.input =
      "stage 3\nhome\nstage 50\nstage 165\nstage 165 anyway\nstage 170 anyway\nwhere\nmarkers 1\n"
      "fly\nquit\n";
  const Outcome outcome = run_program(
      {"jog", "--rig", grbl_rig(path("grbl")), "--transcript", path("wire.jsonl")}, typing);
  EXPECT_EQ(outcome.status, 1) << "some of it was refused";
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("stage: 0.000 mm"), HasSubstr("stands at 50.000 mm"),
                                 HasSubstr("stands at 165.000 mm"), Not(HasSubstr("170"))));
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("home it first"), HasSubstr("beyond the soft limits 1 to 160"),
                    HasSubstr("beyond the stage's travel"), HasSubstr("has no marker lights"),
                    HasSubstr("no command fly"), HasSubstr("5 of the commands failed")));
  peer.with_firmware([&] { EXPECT_NEAR(firmware.place(0), 165, 0.01); });
  EXPECT_THAT(read_text(path("wire.jsonl")), HasSubstr("\"to\": \"device\""));
}

TEST_F(RigCommands, JogWorksOnTheTwin) {
  Surroundings typing;
  typing.input = "home\nstage 50\nmarkers 0 2\nwhere\nleds 0.5\nshoot 0.01 " + path("a.png") +
                 "\nhome platform\nplatform 90\noff\nwhere\n";
  const std::string file = rig_file(
      "[stage]\ndriver = \"simulated\"\n[platform]\ndriver = \"simulated\"\n[markers]\ndriver = "
      "\"simulated\"\n[leds]\ndriver = \"simulated\"\n[camera]\ndriver = \"simulated\"\n"
      "[simulation]\nscale = 0.05\n");
  const Outcome outcome = run_program({"jog", "--rig", file}, typing);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("markers: 0 2"), HasSubstr("platform: 90.000 deg"),
                                 HasSubstr("markers: none"), HasSubstr("368 x 246 pixels")));
  EXPECT_TRUE(std::filesystem::exists(path("a.png")));
}

TEST_F(RigCommands, JogReadsTheMeter) {
  World world("card", 0.02, 7);
  world.light.led_drive = 0.5;
  JetiFirmware firmware(world);
  const PtyPeer peer(firmware, path("jeti"), 100);
  Surroundings typing;
  typing.input = "aim on\naim off\nmeasure\nmeasure " + path("white.csv") + "\naim up\n";
  const Outcome outcome = run_program(
      {"jog", "--rig",
       rig_file("[spectroradiometer]\ndriver = \"jeti\"\nport = \"" + path("jeti") + "\"\n")},
      typing);
  EXPECT_EQ(outcome.status, 1) << "some of it was refused";
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("cd/m², x 0."), HasSubstr("white.csv: 401 values")));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("say aim on or aim off"), HasSubstr("1 of the")));
  EXPECT_THAT(read_text(path("white.csv")),
              AllOf(HasSubstr("wavelength_nm,radiance_w_sr_m2_nm\n380,"), HasSubstr("\n780,")));
}

TEST_F(RigCommands, CaptureTakesTheRigFromItsFile) {
  const std::string file = rig_file(
      "[stage]\ndriver = \"simulated\"\n[markers]\ndriver = \"simulated\"\n[leds]\ndriver = "
      "\"simulated\"\n[camera]\ndriver = \"simulated\"\n[simulation]\nscale = 0.05\nscene = "
      "\"sphere\"\n");
  const Outcome outcome =
      run_program({"capture", path("d"), "--rig", file, "--views", "2", "--exposures", "0.05"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const DatasetManifest manifest = Dataset(path("d")).read_manifest();
  EXPECT_EQ(manifest.source, "test");
  EXPECT_EQ(manifest.scene, "sphere");
  const Outcome both = run_program({"capture", path("e"), "--rig", file, "--scene", "card"});
  EXPECT_NE(both.status, 0) << "the scene stands in the rig file";
  expect_refused(
      run_program({"capture", path("f"), "--rig", rig_file("[stage]\ndriver = \"simulated\"\n")}),
      {"this rig has no", "name one in the rig file"});
}

TEST_F(RigCommands, CaptureGoesOnWhereFailingDevicesEndedIt) {
  const std::vector<std::string> capture = {"capture", path("d"), "--scale",     "0.05",
                                            "--views", "2",       "--exposures", "0.05",
                                            "--chaos", "often"};
  Outcome outcome;
  for (int i = 0; i < 50 && outcome.status != 0; ++i) {
    outcome = run_program(capture);
    if (outcome.status != 0) {
      EXPECT_THAT(outcome.err, HasSubstr("the simulated "));
    }
  }
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST_F(RigCommands, CommandsAtDevicesThatFail) {
  Surroundings typing;
  for (int i = 0; i < 500; ++i) typing.input += "markers 1\n";
  const Outcome jog = run_program({"jog", "--rig",
                                   rig_file("[markers]\ndriver = \"simulated\"\n"
                                            "[simulation]\nscale = 0.02\n"),
                                   "--chaos", "often"},
                                  typing);
  EXPECT_EQ(jog.status, 1);
  EXPECT_THAT(jog.err, AllOf(HasSubstr("the simulated markers"), HasSubstr("commands failed")));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"capture", path("e")},
                                                  {"jog", "--rig", grbl_rig(path("tty"))},
                                                  {"present", path("e")},
                                                  {"calibrate", "eyes", path("e")},
                                                  {"demo", "--out", path("e")},
                                                  {"emulate", "grbl"}}) {
    std::vector<std::string> wild = command;
    wild.insert(wild.end(), {"--chaos", "wild"});
    const Outcome outcome = run_program(wild);
    EXPECT_NE(outcome.status, 0);
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("wild"), HasSubstr("rare")));
  }
  EXPECT_FALSE(std::filesystem::exists(path("e")));
}

TEST_F(RigCommands, FaultsOnCueNeedATwin) {
  GrblFirmware firmware;
  const PtyPeer peer(firmware, path("grbl"), 20);
  expect_refused(run_program({"jog", "--rig", grbl_rig(path("grbl")), "--chaos", "often"}),
                 {"need a simulated rig", "leave --chaos out"});
}

TEST_F(RigCommands, TheDemoEndsWhereADeviceFails) {
  // With the seed of the demo some call fails before it is done.
  const Outcome outcome = run_program(
      {"demo", "--out", path("demo"), "--scene", "card", "--scale", "0.05", "--chaos", "often"});
  expect_refused(outcome, {"the simulated "});
  EXPECT_FALSE(std::filesystem::exists(path("demo/report.html")));
}

TEST_F(RigCommands, EmulateServesAnyClient) {
  const std::string link = path("grbl");
  std::string answer;
  Surroundings until_answered;
  until_answered.kill_when = [&] {
    if (!std::filesystem::exists(link)) return false;
    SteadyClock clock;
    SerialPort client("a client", link, 115200);
    client.write("\x18", clock.in(Duration::of(5)));
    client.write("$I\n", clock.in(Duration::of(5)));
    while (answer.find("ok") == std::string::npos) answer += client.read(clock.in(Duration::of(5)));
    return true;
  };
  run_program({"emulate", "grbl", "--link", link}, until_answered);
  EXPECT_THAT(answer, AllOf(HasSubstr("Grbl 1.1h"), HasSubstr("[VER:1.1h")));
  std::filesystem::remove(link);  // it was killed
  expect_refused(run_program({"emulate", "toaster"}), {"toaster", "grbl"});
  write_text_atomically(path("file"), "x");
  expect_refused(run_program({"emulate", "grbl", "--link", path("file")}), {"file"});
  expect_refused(run_program({"emulate", "grbl", "--speed", "0"}), {"time scale"});
}

TEST_F(RigCommands, EmulatedLinesFailOnCue) {
  const std::string link = path("grbl");
  int asked = 0, failed = 0;
  Surroundings until_it_fails;
  until_it_fails.kill_when = [&] {
    if (!std::filesystem::exists(link)) return false;
    const SteadyClock clock;
    SerialPort client("a client", link, 115200);
    for (; asked < 2000 && failed == 0; ++asked) {
      try {
        client.write("$I\n", clock.in(Duration::of(1)));
        std::string answer;
        while (!answer.ends_with("ok\r\n")) answer += client.read(clock.in(Duration::of(0.2)));
      } catch (const DeviceError&) {
        ++failed;
      }
    }
    return true;
  };
  run_program({"emulate", "grbl", "--link", link, "--chaos", "often"}, until_it_fails);
  EXPECT_EQ(failed, 1) << "of " << asked;
  std::filesystem::remove(link);
}

}  // namespace
}  // namespace wheatstone::apps
