#include "hardware/video/v4l2_driver.h"

#include <gmock/gmock.h>

#include "core/files.h"
#include "hardware/video/v4l2_camera.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

TEST(V4l2Driver, IsReadFromTheRigFile) {
  const TemporaryFolder folder;
  const auto file = folder.path / "video.toml";
  DriverCatalogue catalogue;
  add_v4l2_driver(catalogue);
  const auto read = [&](const std::string& keys) {
    write_text_atomically(file, "driver = \"v4l2\"\n" + keys);
    return catalogue.read<VideoCamera>(TomlTable::read(file, "docs/rig_file.md"));
  };
  EXPECT_EQ(read("node = \"/dev/video9\"\n").address, "/dev/video9");
  EXPECT_EQ(read("usb_serial = \"A1\"\ntransfer = \"userptr\"\n").address, "usb A1");
  EXPECT_THAT(error_of([&] { read(""); }), HasSubstr("node"));
  EXPECT_THAT(error_of([&] { read("node = \"x\"\nbuffers = 1\n"); }), HasSubstr("buffers"));
  EXPECT_THAT(error_of([&] { read("node = \"x\"\ntransfer = \"dma\"\n"); }), HasSubstr("mmap"));
}

TEST(V4l2Driver, RefusesSettingsThatCannotBe) {
  EXPECT_THAT(error_of([] { V4l2Camera{{}}; }), HasSubstr("no address"));
  V4l2CameraSettings settings;
  settings.node = "/dev/video0";
  settings.buffers = 1;
  EXPECT_THAT(error_of([&] { V4l2Camera{settings}; }), HasSubstr("use 2 to 32"));
}

}  // namespace
}  // namespace wheatstone
