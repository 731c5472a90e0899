// A full disk, played by a limit on the size of a file: what cannot be written whole is not there.
#include <filesystem>
#include <string>

#include "apps/stations.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using NoSpace = TemporaryFolder;

/// The largest of the regular files of a folder: the one that a limit below its size hits.
fs::path largest_file(const fs::path& folder, const std::string& extension) {
  fs::path largest;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == extension &&
        (largest.empty() || entry.file_size() > fs::file_size(largest)))
      largest = entry.path();
  return largest;
}

// One byte short: even the last write, when the file is closed, has to be checked.
Surroundings one_byte_short_of(const fs::path& file) {
  return {{}, fs::file_size(file) - 1};
}

TEST_F(NoSpace, Exr) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  ASSERT_EQ(run_program({"render", path("d"), "--cpu"}).status, 0);
  const fs::path target = largest_file(dataset.file("targets"), ".exr");
  const Surroundings full = one_byte_short_of(target);
  fs::remove_all(dataset.file("targets"));
  fs::remove(dataset.file("targets.json"));
  expect_refused(run_program({"render", path("d"), "--cpu"}, full), {target.string(), "space"});
  EXPECT_FALSE(fs::exists(target));
  EXPECT_FALSE(fs::exists(dataset.file("targets.json")));
  expect_nothing_half_written(root_);
}

TEST_F(NoSpace, DrivePng) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  render_drlf(dataset, 0.0, false, [](const std::string&, int, int) {});
  split_to_drive_frames(dataset);
  const fs::path frame = largest_file(dataset.file("drive"), ".png");
  const Surroundings full = one_byte_short_of(frame);
  fs::remove_all(dataset.file("drive"));
  fs::remove(dataset.file("drive.json"));
  expect_refused(run_program({"present", path("d")}, full), {frame.string(), "disk"});
  EXPECT_FALSE(fs::exists(frame));
  EXPECT_FALSE(fs::exists(dataset.file("drive.json")));
  expect_nothing_half_written(root_);
}

TEST_F(NoSpace, Json) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  const Surroundings full = one_byte_short_of(dataset.file("eyes.json"));
  fs::remove(dataset.file("eyes.json"));
  expect_refused(run_program({"calibrate", "eyes", path("d")}, full),
                 {dataset.file("eyes.json").string(), "disk"});
  EXPECT_FALSE(fs::exists(dataset.file("eyes.json")));
  expect_nothing_half_written(root_);
}

TEST_F(NoSpace, AnOldResultStaysWhole) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  const auto old_size = fs::file_size(dataset.file("eyes.json"));
  expect_refused(run_program({"calibrate", "eyes", path("d")}, {{}, old_size / 2}), {"eyes.json"});
  EXPECT_EQ(fs::file_size(dataset.file("eyes.json")), old_size);
  EXPECT_EQ(dataset.read_eyes().size(), kDisplays.size());
  expect_nothing_half_written(root_);
}

TEST_F(NoSpace, ACaptureWithoutItsFramesIsNoDataset) {
  expect_refused(run_program({"capture", path("d"), "--scale", "0.05", "--views", "1"}, {{}, 8192}),
                 {path("d/raw/view_000_exposure_0.png"), "disk"});
  EXPECT_FALSE(fs::exists(path("d/raw/view_000_exposure_0.png")));
  EXPECT_FALSE(fs::exists(path("d/dataset.json")));
  expect_nothing_half_written(root_);
  expect_refused(run_program({"merge", path("d")}), {path("d/dataset.json"), "wheatstone capture"});
}

}  // namespace
}  // namespace wheatstone::apps
