#include "hardware/rig_file/rig_file.h"

#include <gmock/gmock.h>

#include "core/error.h"
#include "core/files.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kHead = "schema = \"wheatstone-rig/1\"\nname = \"x\"\n";
const std::string kSafety = "[safety]\nluminance_limit_cd_m2 = 3000\n";
const std::string kGrbl = "[stage]\ndriver = \"grbl\"\nport = \"/dev/a\"\ntravel_mm = 167\n";

class RigFileTest : public ::testing::Test {
 protected:
  RigFileTest() {
    add_simulated_drivers(catalogue_);
    add_serial_drivers(catalogue_);
    catalogue_.add_missing("gphoto2", "libgphoto2-dev");
  }
  RigDescription read(const std::string& body) {
    write_text_atomically(file_, kHead + body);
    return read_rig_file(file_, catalogue_);
  }
  std::string refusal(const std::string& body) {
    const std::string text = error_of([&] { read(body); });
    EXPECT_THAT(text, AllOf(HasSubstr(file_.string()), HasSubstr("; "))) << body;
    return text;
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path / "rig.toml";
  DriverCatalogue catalogue_;
};

TEST_F(RigFileTest, ReadsDevicesGeometryAndSafety) {
  const RigDescription rig = read(
      kGrbl + "[platform]\ndriver = \"grbl\"\nport = \"/dev/a\"\ntravel_deg = 200\n" + kSafety +
      "watchdog_s = 30\n[geometry]\nmarkers_rsb_mm = [[1, 2, 3], [4, 5, 6]]\n"
      "[[output]]\nrole = \"operator\"\nconnector = \"DP-1\"\nwidth_px = 1920\nheight_px = 1080\n");
  EXPECT_EQ(rig.name, "x");
  ASSERT_EQ(rig.devices().size(), 2U) << "two axes of one controller may share its address";
  EXPECT_EQ(rig.devices()[0].driver, "grbl");
  EXPECT_EQ(rig.luminance_limit, 3000.0_cd_m2);
  EXPECT_EQ(rig.watchdog, 30.0_s);
  EXPECT_EQ(rig.marker_positions_rsb_mm.at(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(rig.outputs.at(0).connector, "DP-1");
  EXPECT_FALSE(rig.simulated());
}

TEST_F(RigFileTest, RefusesWhatIsWrongByLineAndKey) {
  EXPECT_THAT(refusal(kGrbl), HasSubstr("\"safety\" is missing"));
  EXPECT_THAT(refusal(kGrbl + "sped = 3\n" + kSafety),
              AllOf(HasSubstr("line 7"), HasSubstr("\"stage.sped\" is not a key")));
  EXPECT_THAT(
      refusal("[stage]\ndriver = \"grbl\"\nport = \"/dev/a\"\ntravel_cm = 16.7\n" + kSafety),
      AllOf(HasSubstr("line 6"), HasSubstr("use \"travel_mm\"")));
  EXPECT_THAT(refusal("[stage]\ndriver = \"zaber\"\n" + kSafety),
              AllOf(HasSubstr("line 4"), HasSubstr("arduino-gantry, grbl, simulated")));
  EXPECT_THAT(refusal("[camera]\ndriver = \"gphoto2\"\n" + kSafety),
              AllOf(HasSubstr("built without"), HasSubstr("libgphoto2-dev")));
  EXPECT_THAT(refusal(kGrbl + "[stge]\n" + kSafety), HasSubstr("\"stge\" is not a key"));
  EXPECT_THAT(refusal("[stage]\ndriver = \"grbl\"\nport = \"/dev/a\"\ntravel_mm = -5\n" + kSafety),
              HasSubstr("\"stage.travel_mm\" must be a number from"));
  EXPECT_THAT(refusal(kGrbl + "axis = \"Z\"\n" + kSafety), HasSubstr("\"X\" or \"Y\""));
  EXPECT_THAT(refusal(kGrbl + "[safety]\nluminance_limit_cd_m2 = 1e9\n"), HasSubstr("0.01"));
}

TEST_F(RigFileTest, RefusesInvertedLimits) {
  EXPECT_THAT(refusal(kGrbl + kSafety + "[soft_limits]\nstage_mm = [160, 5]\n"),
              AllOf(HasSubstr("soft_limits.stage_mm"), HasSubstr("inverted")));
  EXPECT_EQ(read(kGrbl + kSafety + "[soft_limits]\nstage_mm = [5, 160]\n").soft_stage->at(1),
            160.0_mm);
}

TEST_F(RigFileTest, RefusesTwoDevicesAtOneAddress) {
  EXPECT_THAT(
      refusal(kGrbl +
              "[platform]\ndriver = \"grbl\"\nport = \"/dev/a\"\naxis = \"X\"\ntravel_deg = 200\n" +
              kSafety),
      AllOf(HasSubstr("/dev/a"), HasSubstr("where the stage is")));
}

TEST_F(RigFileTest, RefusesMissingCalibrationFiles) {
  EXPECT_THAT(refusal(kGrbl + kSafety + "[calibration]\ncamera = \"nowhere.json\"\n"),
              AllOf(HasSubstr("calibration.camera"), HasSubstr("nowhere.json")));
}

TEST_F(RigFileTest, RefusesSimulatedAndRealDevicesTogether) {
  EXPECT_THAT(refusal(kGrbl + "[leds]\ndriver = \"simulated\"\n" + kSafety), HasSubstr("clock"));
}

TEST_F(RigFileTest, OpensAllDevicesOrNone) {
  const RigDescription rig =
      read("[stage]\ndriver = \"grbl\"\nport = \"" + (folder_.path / "none").string() +
           "\"\ntravel_mm = 167\n" + kSafety);
  SteadyClock clock;
  try {
    OpenRig(rig, clock, {clock.in(1.0_s), nullptr, {}});
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_EQ(e.kind(), DeviceError::Kind::kNotFound);
  }
}

TEST(Fitted, DeviceThatIsLackingIsNamed) {
  SimulatedClock clock;
  const Rig rig(clock);
  EXPECT_THAT(error_of([&] { rig.stage->stop(); }), HasSubstr("this rig has no camera rail"));
  EXPECT_NO_THROW(make_safe(rig));
}

}  // namespace
}  // namespace wheatstone
