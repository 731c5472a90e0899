// The rig file's keys of head trackers and light sensors.

#include <gmock/gmock.h>

#include "core/error.h"
#include "core/files.h"
#include "hardware/rig_file/rig_file.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

class StreamDrivers : public ::testing::Test {
 protected:
  StreamDrivers() { add_stream_drivers(catalogue_); }
  RigDescription read(const std::string& body) {
    write_text_atomically(file_, "schema = \"wheatstone-rig/1\"\nname = \"x\"\n" + body +
                                     "[safety]\nluminance_limit_cd_m2 = 3000\n");
    return read_rig_file(file_, catalogue_);
  }
  std::string refusal(const std::string& body) {
    return error_of([&] { read(body); });
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path / "rig.toml";
  DriverCatalogue catalogue_;
};

TEST_F(StreamDrivers, AreReadFromTheRigFile) {
  const RigDescription rig = read(
      "[head_tracker]\ndriver = \"udp-head-tracker\"\nudp_port = 7788\nserial = \"T-1\"\n"
      "[light_sensor]\ndriver = \"photodiode\"\nport = \"/dev/serial/by-id/p\"\n");
  ASSERT_EQ(rig.devices().size(), 2U);
  EXPECT_EQ(rig.devices()[0].address, "udp 7788");
  EXPECT_EQ(rig.devices()[1].address, "/dev/serial/by-id/p");
}

TEST_F(StreamDrivers, RefuseWhatIsWrong) {
  EXPECT_THAT(refusal("[head_tracker]\ndriver = \"serial-head-tracker\"\n"),
              HasSubstr("\"head_tracker.port\""));
  EXPECT_THAT(refusal("[head_tracker]\ndriver = \"udp-head-tracker\"\nudp_port = 0\n"),
              HasSubstr("udp_port"));
  EXPECT_THAT(refusal("[head_tracker]\ndriver = \"serial-head-tracker\"\nport = \"/dev/a\"\n"
                      "[light_sensor]\ndriver = \"photodiode\"\nport = \"/dev/a\"\n"),
              HasSubstr("/dev/a"));
}

}  // namespace
}  // namespace wheatstone
