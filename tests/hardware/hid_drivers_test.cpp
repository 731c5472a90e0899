#include "hardware/hid/hid_drivers.h"

#include <gmock/gmock.h>

#include "core/files.h"
#include "hardware/hid/blink1.h"
#include "hardware/hid/relay_board.h"
#include "hardware/rig_file/rig_file.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

class HidDrivers : public ::testing::Test {
 protected:
  HidDrivers() { add_hid_drivers(catalogue_); }
  RigDescription read(const std::string& markers) {
    write_text_atomically(file_, "schema = \"wheatstone-rig/1\"\nname = \"x\"\n[markers]\n" +
                                     markers +
                                     "[geometry]\nmarkers_rsb_mm = [[10, 10, 0]]\n"
                                     "[safety]\nluminance_limit_cd_m2 = 3000\n");
    return read_rig_file(file_, catalogue_);
  }
  std::string refusal(const std::string& markers) {
    return error_of([&] { read(markers); });
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path / "rig.toml";
  DriverCatalogue catalogue_;
};

TEST_F(HidDrivers, AreReadFromTheRigFile) {
  EXPECT_EQ(read("driver = \"hid-relay\"\nboard = \"BITFT\"\nsettle_s = 0\n").markers->address,
            "relay BITFT");
  EXPECT_EQ(
      read("driver = \"blink1\"\nserial = \"2A00CAFE\"\ncolour = [255, 120, 0]\n").markers->address,
      "blink1 2A00CAFE");
}

TEST_F(HidDrivers, RefuseWhatIsWrong) {
  EXPECT_THAT(refusal("driver = \"hid-relay\"\n"), HasSubstr("markers.board"));
  EXPECT_THAT(refusal("driver = \"hid-relay\"\nboard = \"TOOLONG\"\n"), HasSubstr("five"));
  EXPECT_THAT(refusal("driver = \"hid-relay\"\nboard = \"BITFT\"\nsettle_s = 2\n"),
              HasSubstr("settle_s"));
  EXPECT_THAT(refusal("driver = \"blink1\"\n"), HasSubstr("markers.serial"));
  EXPECT_THAT(refusal("driver = \"blink1\"\nserial = \"1\"\ncolour = [0, 0, 0]\n"),
              HasSubstr("black"));
  EXPECT_THAT(refusal("driver = \"blink1\"\nserial = \"1\"\ncolour = [0, 0, 256]\n"),
              HasSubstr("colour"));
  EXPECT_THAT(refusal("driver = \"blink1\"\nserial = \"1\"\nboard = \"BITFT\"\n"),
              HasSubstr("markers.board"));
}

TEST_F(HidDrivers, SettingsThatCannotBeAreRefused) {
  const Deadline soon = SteadyClock().in(Duration::of(1));
  EXPECT_THAT(error_of([&] { RelayBoard({"ABC", {}, nullptr}, soon); }), HasSubstr("no name"));
  EXPECT_THAT(error_of([&] {
                RelayBoard({"BITFT", Duration::of(-1), nullptr}, soon);
              }),
              HasSubstr("settle"));
  EXPECT_THAT(error_of([&] { Blink1({"", {255, 0, 0}, nullptr}, soon); }), HasSubstr("serial"));
  EXPECT_THAT(error_of([&] { Blink1({"1", {0, 0, 0}, nullptr}, soon); }), HasSubstr("black"));
}

}  // namespace
}  // namespace wheatstone
