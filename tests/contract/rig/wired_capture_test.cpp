// `wheatstone capture` through the real drivers to the ends of emulated wires, undisturbed and with
// cables pulled.

#include <gmock/gmock.h>

#include <map>

#include "core/random.h"
#include "tests/contract/rig/wired_rig.h"
#include "tests/program_output.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;
using Device = WiredRig::Device;
using Pictures = std::map<std::string, std::vector<std::byte>>;

constexpr int kViews = 11, kExposures = 3;
constexpr std::size_t kFrames = kViews * (kExposures + 1) + 1;

Pictures pictures_of(const fs::path& dataset) {
  Pictures out;
  for (const auto& entry : fs::directory_iterator(dataset / "raw"))
    if (entry.path().extension() == ".png")
      out[entry.path().filename().string()] = read_bytes(entry.path());
  return out;
}

class WiredCapture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    output_of(std::string(WHEATSTONE_PROGRAM) + " capture " + (folder.path / "twin").string() +
              " --scale " + std::to_string(kWiredScale) + " --seed " + std::to_string(kWiredSeed) +
              plan());
    twin_ = pictures_of(folder.path / "twin");
    ASSERT_EQ(twin_.size(), kFrames);
  }
  static std::string plan() {
    return " --views " + std::to_string(kViews) + " --exposures 1/250 1/60 1/15";
  }
  /// Exit status and what it says.
  std::pair<int, std::string> capture(const fs::path& dataset) {
    const std::string said =
        output_of("{ timeout 120 " WHEATSTONE_PROGRAM " capture " + dataset.string() + " --rig " +
                  (folder_.path / "rig.toml").string() + plan() + "; echo status $?; }");
    return {std::stoi(said.substr(said.rfind("status ") + 7)), said};
  }

  static inline Pictures twin_;
  TemporaryFolder folder_;
};

TEST_F(WiredCapture, GivesThePicturesOfTheTwin) {
  WiredRig rig(folder_.path);
  const fs::path dataset = folder_.path / "wired";
  const auto [status, said] = capture(dataset);
  ASSERT_EQ(status, 0) << said;
  EXPECT_TRUE(pictures_of(dataset) == twin_);
  EXPECT_EQ(rig.light().marker_mask, 0U);
  EXPECT_EQ(rig.light().led_drive, 0);
  EXPECT_TRUE(rig.comes_to_rest());
  EXPECT_EQ(std::distance(fs::directory_iterator(dataset / "raw"), {}), 2 * kFrames)
      << "with the camera's own files";
}

TEST_F(WiredCapture, TwentyPulledCablesLoseNothing) {
  constexpr int kCables = 20;
  // About what the program sends in its start and three frames.
  constexpr std::array<std::pair<Device, int>, 4> kMost = {
      {{Device::kRail, 600}, {Device::kMarkers, 24}, {Device::kLeds, 300}, {Device::kCamera, 400}}};
  RandomStream random(17, 1);
  int pulled = 0, sessions = 0;
  fs::path dataset;
  while (pulled < kCables) {
    dataset = folder_.path / ("session_" + std::to_string(sessions++));
    int status = 1;
    while (status != 0) {
      WiredRig rig(folder_.path);
      const auto [device, most] = kMost[static_cast<std::size_t>(4 * random.uniform())];
      const int after = 1 + static_cast<int>(most * random.uniform());
      if (pulled < kCables) rig.unplug_after(device, after);
      std::string said;
      std::tie(status, said) = capture(dataset);
      if (status == 0) break;
      ASSERT_EQ(status, 1) << said;
      ASSERT_LT(pulled, kCables) << "nothing was pulled: " << said;
      ++pulled;
      EXPECT_THAT(said, ::testing::HasSubstr("wheatstone: ")) << said;
      EXPECT_FALSE(fs::exists(dataset / "dataset.json")) << said;
      EXPECT_EQ(rig.light().marker_mask, 0U) << said;
      // Its LEDs keep their light when the Fadecandy has lost the host.
      if (device != Device::kLeds) {
        EXPECT_EQ(rig.light().led_drive, 0) << said;
      }
      EXPECT_TRUE(rig.comes_to_rest()) << said;
    }
    ASSERT_EQ(status, 0);
    EXPECT_TRUE(pictures_of(dataset) == twin_) << sessions;
  }
  EXPECT_EQ(pulled, kCables);
}

}  // namespace
}  // namespace wheatstone
