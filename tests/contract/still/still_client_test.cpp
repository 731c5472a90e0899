// Another program as the emulated body's host: it is more than our driver's mirror image.

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>

#include "core/camera_raw.h"
#include "core/dataset.h"
#include "tests/contract/still/still_backends.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

/// What the command prints; its exit status must be 0.
std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(
      ::popen((command + " 2>&1 </dev/null").c_str(), "r"), [](FILE*) { return 0; });
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), n);
  const int status = ::pclose(pipe.get());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command << "\n" << text;
  return text;
}

TEST(StillClient, AnotherProgramTakesWhatTheTwinTakes) {
  const std::string client = WHEATSTONE_GPHOTO2;
  if (client.empty()) GTEST_SKIP() << "gphoto2 is not installed (package gphoto2)";
  GphotoBackend body;
  TwinStillBackend twin;
  body.world().light.led_drive = twin.world().light.led_drive = 1;
  const TemporaryFolder folder;
  const std::string run = "cd " + folder.path.string() + " && HOME=" + folder.path.string() +
                          " LC_ALL=C timeout 30 " + client + " ";

  EXPECT_THAT(output_of(run + "--auto-detect"), HasSubstr("Sony Alpha-A7r III (PC Control)"));
  const std::string summary = output_of(run + "--summary");
  EXPECT_THAT(summary, HasSubstr("ILCE-7RM3"));
  EXPECT_THAT(summary, HasSubstr(body.world().camera_profile.serial));
  const std::string times = output_of(run + "--get-config shutterspeed");
  for (const char* time : {" 30\n", " 13/10\n", " 1/250\n", "Current: 1/60\n"})
    EXPECT_THAT(times, HasSubstr(time));

  output_of(run + "--set-config shutterspeed=1/250 --capture-image-and-download --filename a.arw");
  const CameraRaw raw = read_camera_raw(folder.path / "a.arw");
  const Duration exposure = Duration::of(1 / 250.0);
  const RawFrame expected = twin.camera().expose(exposure, twin.clock().in(Duration::of(5)));
  EXPECT_EQ(cv::norm(raw.mosaic.dn, expected.mosaic.dn, cv::NORM_INF), 0);
  EXPECT_EQ(raw.exposure_s, exposure.value());
  EXPECT_EQ(raw.serial, expected.camera_serial);
}

TEST(StillClient, DoctorFindsTheBodyByItsSerialAndNamesOthers) {
  PtpCameraOptions one, other;
  one.serial = "ONE";
  other.serial = "OTHER";
  World world("card", 0.02, 7);
  const GphotoBackend first(world, one), second(world, other, StillUsbFirmware::kPcRemote, "2");
  const TemporaryFolder folder;
  write_camera_profile(folder.path / "camera.json", world.camera_profile);
  write_text_atomically(folder.path / "rig.toml",
                        "schema = \"wheatstone-rig/1\"\nname = \"test\"\n"
                        "[camera]\ndriver = \"gphoto2\"\nserial = \"ONE\"\n"
                        "[calibration]\ncamera = \"camera.json\"\n"
                        "[safety]\nluminance_limit_cd_m2 = 3000\n");
  const std::string report =
      output_of(std::string("timeout 60 ") + WHEATSTONE_PROGRAM + " doctor --json --rig " +
                (folder.path / "rig.toml").string() + " || true");
  EXPECT_THAT(report, HasSubstr(R"("serial": "ONE")"));
  EXPECT_THAT(report, HasSubstr("serial OTHER"));
  EXPECT_LT(report.find(R"("serial": "ONE")"), report.find("other_devices"));
  EXPECT_GT(report.find("serial OTHER"), report.find("other_devices"));
}

}  // namespace
}  // namespace wheatstone
