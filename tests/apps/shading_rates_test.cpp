// `wheatstone quality allocate`, `map` and `refresh`: answers, and what they say to input they
// cannot use.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/allocation_instance.h"
#include "core/csv.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/png.h"
#include "core/random.h"
#include "program.h"
#include "rendering/motion_quality/alsarr/quality_polynomial.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kInstances =
    std::string(WHEATSTONE_SOURCE_DIR) + "/tests/vectors/motion_quality/knapsack_instances.json";

json parse(const fs::path& file) {
  std::ifstream in(file);
  return json::parse(in);
}

class AllocateInstance : public TemporaryFolder {
 protected:
  AllocateInstance() {
    instance_ = parse(kInstances)["instances"][0];
    for (const char* answer : {"greedy_selection", "exact_optimum"})
      expected_[answer] = instance_[answer];
  }
  Outcome run(const std::string& solver = "exact") {
    std::ofstream(path("in.json")) << instance_.dump();
    return run_program({"quality", "allocate", "--input", path("in.json"), "--solver", solver,
                        "--output", path("out.json")});
  }
  void expect_input_refused(const std::vector<std::string>& parts) {
    expect_refused(run(), parts);
    EXPECT_FALSE(fs::exists(path("out.json")));
    expect_nothing_half_written(root_);
  }

  json instance_, expected_;
};

TEST_F(AllocateInstance, AnswersOfAllSolvers) {
  for (const std::string solver : {"greedy", "exact", "fast"}) {
    const Outcome outcome = run(solver);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json out = parse(path("out.json"));
    EXPECT_EQ(out["solver"], solver);
    EXPECT_EQ(out["budget"], instance_["budget"]);
    EXPECT_LE(out["total_cost"], out["budget"]);
    ASSERT_EQ(out["choice"].size(), 12u);
    if (solver == "greedy") {
      EXPECT_EQ(out["choice"], expected_["greedy_selection"]);
    } else {
      EXPECT_NEAR(out["total_quality"], expected_["exact_optimum"], 1e-9);
      EXPECT_EQ(out["gap_bound"], 0);
    }
  }
}

TEST_F(AllocateInstance, OneOfAList) {
  const Outcome outcome =
      run_program({"quality", "allocate", "--input", kInstances, "--instance", "ties_4x4",
                   "--solver", "exact", "--output", path("out.json")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NEAR(parse(path("out.json"))["total_quality"], 25.225, 1e-9);
  expect_refused(
      run_program({"quality", "allocate", "--input", kInstances, "--output", path("none.json")}),
      {"--instance", "generic_4x3, generic_6x5"});
  expect_refused(run_program({"quality", "allocate", "--input", kInstances, "--instance", "x",
                              "--output", path("none.json")}),
                 {"no instance 'x'"});
  EXPECT_FALSE(fs::exists(path("none.json")));
}

TEST_F(AllocateInstance, TheRecipeGivesTheListedQualities) {
  for (json instance : parse(kInstances)["instances"]) {
    const auto listed = instance["quality"].get<std::vector<std::vector<double>>>();
    instance.erase("quality");
    std::ofstream(path("recipe.json")) << instance.dump();
    const AllocationProblem p = read_allocation_instance(path("recipe.json"));
    ASSERT_EQ(p.tiles(), listed.size());
    for (std::size_t i = 0; i < p.quality.size(); ++i)
      EXPECT_NEAR(p.quality[i], listed[i / kShadingRateCount][i % kShadingRateCount], 1e-12)
          << instance["name"] << " " << i;
  }
}

TEST_F(AllocateInstance, ImpossibleInstances) {
  const json good = instance_;
  instance_["budget"] = 11;
  expect_input_refused({"the least that would do is 12"});
  instance_ = good;
  instance_["quality"][3].erase(6);
  expect_input_refused({"in.json", "tile 3"});
  instance_ = good;
  instance_["quality"][3][1] = nullptr;
  expect_input_refused({"in.json", "tile 3 is null"});
  instance_ = good;
  instance_["quality"].erase(5);
  expect_input_refused({"in.json", "11 tiles"});
  instance_ = good;
  instance_["bandwidth"].erase(0);
  expect_input_refused({"in.json", "6 costs"});
  instance_ = good;
  instance_["bandwidth"][2] = 1.5;
  expect_input_refused({"in.json", "is 1.5"});
  for (const char* key : {"budget", "bandwidth"}) {
    instance_ = good;
    instance_.erase(key);
    expect_input_refused({"in.json", key});
  }
  instance_ = good;
  instance_.erase("quality");
  instance_["mode"] = 3;
  expect_input_refused({"in.json", "\"mode\" is 3"});
  instance_ = good;
  expect_refused(run("best"), {"'best'", "greedy, exact or fast"});
  EXPECT_FALSE(fs::exists(path("out.json")));
}

TEST_F(AllocateInstance, EveryDamageIsAnErrorOrAnInstance) {
  const std::string good = instance_.dump();
  int errors = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    RandomStream random(11, i);
    std::string text = good;
    for (std::uint64_t k = 0; k < 1 + random.next() % 4; ++k)
      text[random.next() % text.size()] ^= static_cast<char>(1u << random.next() % 8);
    if (random.next() % 4 == 0) text.resize(random.next() % text.size());
    std::ofstream(path("fuzz.json")) << text;
    try {
      allocate(read_allocation_instance(path("fuzz.json")), AllocationSolver::kFast);
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 100);
}

/// A frame of 8 x 6 tiles, two materials, and a picture of it.
class AllocateTiles : public TemporaryFolder {
 protected:
  AllocateTiles() {
    RandomStream random(4, 0);
    RgbImage motion(8, 6), materials(8, 6);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        motion.pixels(y, x) = {0.1F * float(x), 0.1F * float(y), 0};
        materials.pixels(y, x) = {float((x + y) % 2), float(x % 12), 0};
      }
    write_exr(path("motion.exr"), motion);
    write_exr(path("materials.exr"), materials);
    std::vector<PolynomialTable::Material> table(2);
    for (auto& material : table)
      for (auto& mip : material.mips)
        for (auto& polynomial : mip)
          for (double& w : polynomial.w) w = 0.01 * random.uniform();
    PolynomialTable(table).write(path("polynomials.csv"));
    cv::Mat3b picture(6 * 16, 8 * 16);
    for (cv::Vec3b& p : picture)
      for (int k = 0; k < 3; ++k) p[k] = static_cast<unsigned char>(random.next() % 256);
    write_picture_png(path("picture.png"), picture);
  }
  std::vector<std::string> arguments(const std::string& command,
                                     const std::vector<std::string>& more) const {
    std::vector<std::string> out = {"quality",       command,
                                    "--motion",      path("motion.exr"),
                                    "--materials",   path("materials.exr"),
                                    "--polynomials", path("polynomials.csv")};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  void expect_tiles_refused(const std::string& budget, const std::vector<std::string>& parts) {
    expect_refused(run_program(arguments("allocate", {"--budget", budget, "--map", path("map.exr"),
                                                      "--picture", path("map.png")})),
                   parts);
    EXPECT_FALSE(fs::exists(path("map.exr")));
    EXPECT_FALSE(fs::exists(path("map.png")));
    expect_nothing_half_written(root_);
  }
};

TEST_F(AllocateTiles, MapPictureAndNumbersAgree) {
  const Outcome outcome =
      run_program(arguments("allocate", {"--budget", "0.25", "--map", path("map.exr"), "--picture",
                                         path("map.png"), "--output", path("out.json")}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const ShadingRateMap map = read_shading_rate_map(path("map.exr"));
  ASSERT_EQ(map.rate_index.size(), cv::Size(8, 6));
  const json out = parse(path("out.json"));
  EXPECT_EQ(out["total_cost"], map.cost_px());
  EXPECT_EQ(out["budget"], 48 * 64);
  EXPECT_EQ(out["choice"][6], map.rate_index(0, 1));  // column by column
  EXPECT_GT(read_srgb_picture(path("map.png"), 100).width(), 8);
}

TEST_F(AllocateTiles, PicturesOfAFrame) {
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, std::vector<std::string>{"--cpu"}}) {
    auto all = arguments(
        "map", {"--budget", "0.125", "--picture", path("picture.png"), "--out", path("pictures")});
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run_program(all);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (const char* name : {"rates.png", "quality.png", "comparison.png", "rates.exr"})
      EXPECT_TRUE(fs::exists(path("pictures") + "/" + name)) << name;
    fs::remove_all(path("pictures"));
  }
}

TEST_F(AllocateTiles, ImpossibleBuffers) {
  expect_tiles_refused("0.06", {"0.0625"});
  expect_tiles_refused("1.5", {"1.5"});
  const std::string good = read_text(path("polynomials.csv"));
  write_text_atomically(path("polynomials.csv"), good + "1,too,short\n");
  expect_tiles_refused("0.25", {"polynomials.csv", "line 50 has 3 cells"});
  write_text_atomically(path("polynomials.csv"), good.substr(0, good.find("\n2,") + 1));
  expect_tiles_refused("0.25", {"tile (0, 1) has material 1", "table has 1"});
  write_text_atomically(path("polynomials.csv"), good);
  write_exr(path("materials.exr"), RgbImage(7, 6));
  expect_tiles_refused("0.25", {"materials.exr", "7x6", "8x6"});
  fs::resize_file(path("motion.exr"), fs::file_size(path("motion.exr")) / 2);
  expect_tiles_refused("0.25", {"motion.exr"});
  expect_refused(run_program({"quality", "allocate", "--budget", "0.25", "--map", path("m.exr")}),
                 {"--motion"});
}

TEST_F(AllocateTiles, APictureLargerThanTheFrame) {
  expect_refused(
      run_program(arguments("map", {"--budget", "0.25", "--picture", path("picture.png"),
                                    "--from-tile", "1", "0", "--out", path("pictures")})),
      {"8x6 tiles from (1, 0) do not lie in 8x6"});
  EXPECT_FALSE(fs::exists(path("pictures")));
}

TEST_F(AllocateTiles, FigureOfTheRefreshTable) {
  expect_refused(run_program({"quality", "plot", "--figure", "6.4", "--output", path("none.svg")}),
                 {"--texture"});
  EXPECT_FALSE(fs::exists(path("none.svg")));
  const Outcome outcome = run_program({"quality", "plot", "--figure", "6.4", "--texture",
                                       path("picture.png"), "--output", path("refresh.svg")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string svg = read_text(path("refresh.svg"));
  for (const char* text : {"Best refresh rate", "speed (deg/s)", "6.25 % of full rate"})
    EXPECT_THAT(svg, ::testing::HasSubstr(text));
}

TEST_F(AllocateTiles, RefreshTableOfAPicture) {
  const Outcome outcome =
      run_program({"quality", "refresh", "--texture", path("picture.png"), "--budget", "0.25",
                   "--speed-deg-per-s", "0", "20", "--min-hz", "60", "--step-hz", "60", "--output",
                   path("refresh.csv"), "--candidates", path("candidates.csv")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(CsvTable::read(path("refresh.csv")).rows(), 2u);
  EXPECT_EQ(CsvTable::read(path("candidates.csv")).rows(), 4u);
  expect_refused(run_program({"quality", "refresh", "--texture", path("picture.png"),
                              "--speed-deg-per-s", "-3", "--output", path("none.csv")}),
                 {"-3"});
  EXPECT_FALSE(fs::exists(path("none.csv")));
}

}  // namespace
}  // namespace wheatstone::apps
