// What the program says to input it cannot use: exit status 1, the file, what to do, and nothing
// half-written.
#include <ImfArray.h>
#include <ImfRgbaFile.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "apps/stations.h"
#include "capture/import/poses_json.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "program.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Any JSON file, without the checks of the readers under test.
json parse(const fs::path& file) {
  std::ifstream in(file);
  return json::parse(in);
}
void store(const fs::path& file, const json& document) {
  std::ofstream(file) << document.dump(1);
}

class BadInput : public TemporaryFolder {
 protected:
  /// Renders "d" and expects a refusal that names `file` and leaves no targets.
  void expect_render_refused(const std::string& file, std::vector<std::string> parts) {
    parts.push_back(path(file));
    expect_refused(run_program({"render", path("d"), "--cpu"}), parts);
    EXPECT_FALSE(fs::exists(path("d/targets.json")));
    EXPECT_FALSE(fs::exists(path("d/targets/left_near.exr")));
    expect_nothing_half_written(root_);
  }
};

TEST_F(BadInput, MissingDataset) {
  for (const std::vector<std::string>& command : {std::vector<std::string>{"merge"},
                                                  {"calibrate", "poses"},
                                                  {"calibrate", "eyes"},
                                                  {"render"},
                                                  {"present"}}) {
    std::vector<std::string> arguments = command;
    arguments.push_back(path("nowhere"));
    expect_refused(run_program(arguments),
                   {path("nowhere/dataset.json"), "wheatstone capture", "wheatstone import"});
    EXPECT_FALSE(fs::exists(path("nowhere")));
  }
  expect_refused(run_program({"import", path("nowhere"), "--out", path("d")}), {path("nowhere")});
  EXPECT_FALSE(fs::exists(path("d")));
  EXPECT_FALSE(fs::exists(path("d/dataset.json")));
}

TEST_F(BadInput, DamagedExr) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  const fs::path view = dataset.file("views/view_1.exr");
  fs::resize_file(view, fs::file_size(view) / 2);
  expect_render_refused("d/views/view_1.exr", {"make or copy the file again"});
  std::ofstream(view) << "no picture at all";
  expect_render_refused("d/views/view_1.exr", {"make or copy the file again"});
}

TEST_F(BadInput, RadianceThatIsNoLight) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0f}) {
    Imf::Array2D<Imf::Rgba> pixels(36, 48);
    for (int r = 0; r < 36; ++r)
      for (int c = 0; c < 48; ++c) pixels[r][c] = Imf::Rgba(1, 1, 1);
    pixels[5][9].g = value;
    {
      Imf::RgbaOutputFile out(dataset.file("views/view_1.exr").c_str(), 48, 36, Imf::WRITE_RGB);
      out.setFrameBuffer(&pixels[0][0], 1, 48);
      out.writePixels(36);
    }
    expect_render_refused("d/views/view_1.exr", {"9", "5", ";"});
  }
}

TEST_F(BadInput, ViewOfAnotherSize) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  write_exr(dataset.file("views/view_2.exr"), RgbImage(40, 36), ExrPrecision::kHalf);
  expect_render_refused("d/views/view_2.exr", {"40x36", "48x36", "import or calibrate"});
}

TEST_F(BadInput, MissingView) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  fs::remove(dataset.file("views/view_2.exr"));
  expect_render_refused("d/views.json", {"view_2", "again"});
}

TEST_F(BadInput, UnknownManifestVersion) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  json manifest = parse(dataset.file("dataset.json"));
  manifest["schema"] = "wheatstone-dataset/2";
  store(dataset.file("dataset.json"), manifest);
  expect_render_refused("d/dataset.json", {"wheatstone-dataset/2", "wheatstone-dataset/1",
                                           "use the program version that wrote it"});
  expect_refused(run_program({"present", path("d")}), {"wheatstone-dataset/2"});
  EXPECT_FALSE(fs::exists(path("d/drive")));
}

TEST_F(BadInput, PosesWithoutTheirConvention) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  json poses = parse(dataset.file("views.json"));
  poses.erase("convention");
  store(dataset.file("views.json"), poses);
  expect_render_refused("d/views.json", {std::string("add \"convention\": \"") + kPoseConvention});
  expect_refused(
      run_program({"import", path("d/views.json"), "--format", "poses", "--out", path("imported")}),
      {path("d/views.json"), kPoseConvention});
  EXPECT_FALSE(fs::exists(path("imported")));
  const std::string before = read_text(dataset.file("dataset.json"));
  expect_refused(
      run_program({"import", path("d/views.json"), "--format", "poses", "--out", path("d")}),
      {path("d"), "holds something already", "new folder"});
  EXPECT_EQ(read_text(dataset.file("dataset.json")), before);
}

TEST_F(BadInput, FewerThanFourMarkers) {
  SimulatedRig twin({"card", 0.1, 7});
  const Rig rig = twin.rig();
  const Dataset dataset(root_ / "d");
  fs::create_directories(dataset.file("raw"));
  dataset.write_manifest({"capture", "card", 7, 0.1, "test", 0, 1});
  dataset.write_camera(rig.camera_profile);
  dataset.write_landmarks({rig.marker_positions_rsb_mm, rig.near_cross_positions_rsb_mm});
  const ExposureRecord frame{"raw/view_000_markers.png", 1 / 60.0};
  dataset.write_frames({{"view_000", 80, 80, {frame}, frame}});

  rig.stage->home(rig.clock.in(60.0_s));
  rig.stage->move_to(Length::of(80), rig.clock.in(60.0_s));
  for (const int lit : {3, 0}) {
    rig.markers->set((1U << lit) - 1, rig.clock.in(60.0_s));
    write_mosaic_png(dataset.file(frame.file),
                     rig.camera->expose(Duration::of(1 / 60.0), rig.clock.in(60.0_s)).mosaic);
    expect_refused(run_program({"calibrate", "poses", path("d")}),
                   {path("d/raw/view_000_markers.png"), "found " + std::to_string(lit) + " of 4",
                    "switch all four LEDs on"});
    EXPECT_FALSE(fs::exists(path("d/poses.json")));
    EXPECT_FALSE(fs::exists(path("d/views.json")));
    expect_nothing_half_written(root_);
  }
}

TEST_F(BadInput, EyeMarksOnOnePlane) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  fs::remove(dataset.file("eyes.json"));
  json marks = parse(dataset.file("alignments.json"));
  for (json& mark : marks["left_far"]) mark["p_rsb_mm"][2] = 100.0;
  store(dataset.file("alignments.json"), marks);
  expect_refused(run_program({"calibrate", "eyes", path("d")}),
                 {path("d/alignments.json"), "left_far", "one plane", "use marks on two planes"});
  EXPECT_FALSE(fs::exists(path("d/eyes.json")));
  expect_nothing_half_written(root_);
}

// A capture has no white of its own, and still a view of it can be left out and compared.
TEST_F(BadInput, ACaptureNeedsNoWhite) {
  write_small_light_field(root_ / "d");
  const Outcome outcome = run_program(
      {"render", path("d"), "--cpu", "--leave-out", "view_1", "--out", path("view_1.exr")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ::testing::HasSubstr("DRLF"));
  EXPECT_EQ(read_exr(path("view_1.exr")).width(), 48);
}

// Tests may run as root, whom permission bits do not stop; these places stop everyone.
TEST_F(BadInput, OutputThatCannotBeWritten) {
  const Dataset dataset = write_small_light_field(root_ / "d");
  std::ofstream(path("file")) << "in the way";
  for (const std::string& out : {path("file/below"), std::string("/proc/nonexistent/below")}) {
    expect_refused(run_program({"capture", out, "--scale", "0.05"}), {out, "check the path"});
    expect_refused(run_program({"import", path("d/views.json"), "--format", "poses", "--out", out}),
                   {out, "check the path"});
    expect_refused(
        run_program({"render", path("d"), "--cpu", "--leave-out", "view_1", "--out", out + ".exr"}),
        {out + ".exr", "folder"});
  }
  expect_nothing_half_written(root_);
}

TEST_F(BadInput, NoOpenGl) {
  write_small_light_field(root_ / "d");
  const Surroundings without_driver{{"__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent"}, {}, {}};
  expect_refused(run_program({"render", path("d")}, without_driver),
                 {"OpenGL", "libgl1-mesa-dri", "--cpu"});
  EXPECT_FALSE(fs::exists(path("d/targets.json")));
  expect_nothing_half_written(root_);
  EXPECT_EQ(run_program({"render", path("d"), "--cpu"}, without_driver).status, 0);
}

}  // namespace
}  // namespace wheatstone::apps
