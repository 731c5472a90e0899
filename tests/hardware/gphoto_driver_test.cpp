#include "hardware/still/gphoto_driver.h"

#include <gmock/gmock.h>

#include "core/files.h"
#include "hardware/still/replay_camera.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

TEST(StillDrivers, AreReadFromTheRigFile) {
  const TemporaryFolder folder;
  const auto file = folder.path / "camera.toml";
  DriverCatalogue catalogue;
  add_gphoto_driver(catalogue);
  add_replay_driver(catalogue);
  const auto read = [&](const std::string& keys) {
    write_text_atomically(file, keys);
    return catalogue.read<StillCamera>(TomlTable::read(file, "docs/rig_file.md"));
  };
  const std::string gphoto = "driver = \"gphoto2\"\n";
  EXPECT_EQ(read(gphoto + "serial = \"A1\"\n").address, "usb A1");
  EXPECT_EQ(read(gphoto + "model = \"A7r III\"\ndelivery_s = 6\n").address, "usb A7r III");
  EXPECT_THAT(error_of([&] { read(gphoto); }), HasSubstr("serial"));
  EXPECT_THAT(error_of([&] { read(gphoto + "serial = \"A\"\ndelivery_s = 0\n"); }),
              HasSubstr("delivery_s"));
  EXPECT_THAT(error_of([&] { read(gphoto + "serial = \"A\"\npower_cycle_limit_s = 1e9\n"); }),
              HasSubstr("power_cycle_limit_s"));
  EXPECT_THAT(error_of([&] { read(gphoto + "serial = \"A\"\nshutter = 1\n"); }),
              HasSubstr("shutter"));
  EXPECT_EQ(read("driver = \"replay\"\nfolder = \"/x\"\n").address, "/x");
  EXPECT_THAT(error_of([&] { read("driver = \"replay\"\n"); }), HasSubstr("folder"));
}

}  // namespace
}  // namespace wheatstone
