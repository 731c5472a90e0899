// The rig file's keys of spectroradiometers and display outputs.

#include <gmock/gmock.h>

#include "core/error.h"
#include "core/files.h"
#include "hardware/rig_file/diagnosis.h"
#include "hardware/rig_file/rig_file.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

class MeterDrivers : public ::testing::Test {
 protected:
  MeterDrivers() { add_meter_drivers(catalogue_); }
  RigDescription read(const std::string& body) {
    write_text_atomically(file_, "schema = \"wheatstone-rig/1\"\nname = \"x\"\n" + body +
                                     "[safety]\nluminance_limit_cd_m2 = 3000\n");
    return read_rig_file(file_, catalogue_);
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path / "rig.toml";
  DriverCatalogue catalogue_;
};

TEST_F(MeterDrivers, AreReadFromTheRigFile) {
  const RigDescription jeti = read(
      "[spectroradiometer]\ndriver = \"jeti\"\nport = \"/dev/serial/by-id/j\"\nbaud = 115200\n"
      "serial = \"12\"\nfloor_cd_m2 = 0.2\n");
  EXPECT_EQ(jeti.devices().at(0).address, "/dev/serial/by-id/j");
  const RigDescription spotread =
      read("[spectroradiometer]\ndriver = \"spotread\"\ninstrument = 2\n");
  EXPECT_EQ(spotread.devices().at(0).address, "spotread instrument 2");
}

TEST_F(MeterDrivers, RefuseWhatIsWrong) {
  const auto refusal = [&](const std::string& keys) {
    return error_of([&] { read("[spectroradiometer]\n" + keys); });
  };
  EXPECT_THAT(refusal("driver = \"jeti\"\n"), HasSubstr("\"spectroradiometer.port\""));
  EXPECT_THAT(refusal("driver = \"jeti\"\nport = \"/dev/a\"\nbaud = 9600\n"), HasSubstr("921600"));
  EXPECT_THAT(refusal("driver = \"jeti\"\nport = \"/dev/a\"\nfloor_cd_m2 = -1\n"),
              HasSubstr("floor_cd_m2"));
  EXPECT_THAT(refusal("driver = \"spotread\"\ninstrument = 0\n"), HasSubstr("instrument"));
  EXPECT_THAT(refusal("driver = \"photometer\"\n"), HasSubstr("jeti, spotread"));
}

TEST_F(MeterDrivers, AreDiagnosed) {
  const auto lines =
      diagnose(read("[spectroradiometer]\ndriver = \"spotread\"\nprogram = \"/no/spotread\"\n"));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].status, "not found");
  EXPECT_THAT(lines[0].problem, HasSubstr("ArgyllCMS"));
}

TEST_F(MeterDrivers, DisplaysThatCannotBeReachedAreNotOk) {
  const auto lines =
      diagnose(read("[[output]]\nrole = \"operator\"\nconnector = \"DP-1\"\nwidth_px = 640\n"
                    "height_px = 480\n"));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].role, "output operator");
  EXPECT_EQ(lines[0].status, "not ready");
  EXPECT_THAT(lines[0].problem, HasSubstr("[display_outputs]"));
}

}  // namespace
}  // namespace wheatstone
