// The program itself at emulated marker lights.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "core/files.h"
#include "tests/contract/lights/lights_backends.h"
#include "tests/program_output.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

class LightsProgram : public ::testing::Test {
 protected:
  LightsProgram() {
    write_text_atomically(rig_,
                          "schema = \"wheatstone-rig/1\"\nname = \"lights\"\n"
                          "[markers]\ndriver = \"hid-relay\"\nboard = \"BITFT\"\n"
                          "[geometry]\nmarkers_rsb_mm = [[20, 20, 0]]\n"
                          "[safety]\nluminance_limit_cd_m2 = 3000\n");
  }
  std::string run(const std::string& command, const std::string& input = "") {
    const auto typed = folder_.path / "typed";
    write_text_atomically(typed, input);
    return output_of("timeout 60 " WHEATSTONE_PROGRAM " " + command + " --rig " + rig_.string() +
                     " < " + typed.string());
  }

  TemporaryFolder folder_;
  std::filesystem::path rig_ = folder_.path / "rig.toml";
};

TEST_F(LightsProgram, DoctorFindsTheBoardAndWhatElseIsPluggedIn) {
  const RelayBackend board(hid_bed(), 0);
  const Blink1Backend other(hid_bed(), 1);
  const std::string report = run("doctor");
  EXPECT_THAT(report, HasSubstr("hid-relay at relay BITFT, USBRelay4"));
  EXPECT_THAT(report, HasSubstr("not named    blink1 2A00CAFE on /dev/hidraw1"));
  EXPECT_EQ(report.find("relay BITFT on"), std::string::npos) << "it is named";
}

TEST_F(LightsProgram, JogLightsMarkersAndLeavesNoneLit) {
  RelayBackend board(hid_bed());
  std::vector<MarkerLights::Mask> seen;
  board.peer().with_firmware([&] {
    board.firmware().spoil = [&](bool to_host, std::string& bytes) {
      if (to_host) seen.push_back(static_cast<unsigned char>(bytes[7]));
      return 0;
    };
  });
  EXPECT_THAT(run("jog", "markers 0 2\nwhere\n"), HasSubstr("markers: 0 2"));
  board.peer().with_firmware([&] { board.firmware().spoil = nullptr; });
  EXPECT_THAT(seen, ::testing::Contains(5U));
  EXPECT_EQ(board.truth(), 0U);
}

}  // namespace
}  // namespace wheatstone
