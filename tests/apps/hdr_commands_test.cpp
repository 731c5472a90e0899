// `merge --frames`, `demosaic` and `estimate-exposures` as a script calls them.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/demosaic.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/png.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kVectors = WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/";

json vectors(const std::string& name) {
  std::ifstream in(kVectors + name);
  return json::parse(in);
}

class HdrCommands : public TemporaryFolder {
 protected:
  void store(const json& document) { std::ofstream(path("frames.json")) << document.dump(1); }

  /// The frames of a stack of merge_stacks.json as 16-bit PNG, and its frames.json.
  json write_stack(const json& v, const std::string& estimator) {
    json frames = json::array();
    for (std::size_t i = 0; i < v["images"].size(); ++i) {
      MosaicImage m{cv::Mat1w(v["rows"].get<int>(), v["cols"].get<int>())};
      for (int r = 0; r < m.height(); ++r)
        for (int c = 0; c < m.width(); ++c) m.dn(r, c) = v["images"][i][r][c].get<std::uint16_t>();
      const std::string name = "frame_" + std::to_string(i) + ".png";
      write_mosaic_png(path(name), m);
      frames.push_back(
          {{"file", name}, {"exposure_s", v["exposure_s"][i]}, {"gain", v["gain"][i]}});
    }
    const json document = {{"pattern", v["pattern"]},
                           {"bits", v["bits"]},
                           {"black", v["black_level"]},
                           {"saturation", (1 << v["bits"].get<int>()) - 1},
                           {"estimator", estimator},
                           {"noise",
                            {{"noise_k_rgb", v["noise_k_rgb"]},
                             {"std_read", v["std_read"]},
                             {"std_adc", v["std_adc"]}}},
                           {"frames", frames}};
    store(document);
    return document;
  }

  Outcome merge(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"merge", "--frames", path("frames.json"), "--out",
                                          path("o.exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  void expect_merge_refused(const json& document, const std::vector<std::string>& parts) {
    store(document);
    expect_refused(merge(), parts);
    EXPECT_FALSE(fs::exists(path("o.exr")));
    expect_nothing_half_written(root_);
  }
};

TEST_F(HdrCommands, MergeWritesTheMosaicWithItsLayers) {
  const json file = vectors("merge_stacks.json");
  const json& v = file["cases"][4];  // oversaturated
  ASSERT_EQ(v["name"], "oversaturated");
  for (const auto& [estimator, key, tolerance] :
       {std::tuple("poisson", "expected_poisson_estimator", 1e-6),
        std::tuple("full", "expected_full_noise_estimator", 1e-5)}) {
    write_stack(v, estimator);
    const Outcome outcome = merge({"--no-demosaic"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::vector<ExrView> views = read_exr_views(path("o.exr"));
    ASSERT_EQ(views.size(), 1u);
    EXPECT_EQ(views[0].channels.size(), 5u);
    const cv::Mat1f& phi = views[0].channels.at("Y").pixels;
    const cv::Mat1f& saturated = views[0].channels.at("mask.saturated").pixels;
    for (int r = 0; r < phi.rows; ++r)
      for (int c = 0; c < phi.cols; ++c) {
        const double expected = v[key][r][c];
        EXPECT_NEAR(phi(r, c), expected, tolerance * std::max(1.0, std::abs(expected)));
        EXPECT_EQ(saturated(r, c), 1 - v["unsaturated_in_shortest"][r][c].get<int>());
        EXPECT_GT(views[0].channels.at("sigma.Y").pixels(r, c), 0);
      }
  }
}

TEST_F(HdrCommands, GlareIsTakenOutOnDemand) {
  const json file = vectors("merge_stacks.json");
  write_stack(file["cases"][0], "poisson");
  const auto glare = [&](const std::string& body) {
    std::ofstream(path("glare.toml")) << "schema = \"wheatstone-glare/1\"\nlens = \"none\"\n"
                                      << body;
    return merge({"--no-demosaic", "--glare-mtf", path("glare.toml")});
  };
  ASSERT_EQ(merge({"--no-demosaic"}).status, 0);
  const cv::Mat1f plain = read_exr_views(path("o.exr"))[0].channels.at("Y").pixels.clone();

  // An MTF of 1 everywhere changes nothing but the sign of what is below 0.
  const Outcome outcome = glare("a1 = 1\nb1 = 0\nc1 = 1e6\na2 = 0\nb2 = 0\nc2 = 1\n");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("glare of the lens taken out"));
  const cv::Mat1f clear = read_exr_views(path("o.exr"))[0].channels.at("Y").pixels;
  for (int r = 0; r < plain.rows; ++r)
    for (int c = 0; c < plain.cols; ++c)
      EXPECT_NEAR(clear(r, c), std::abs(plain(r, c)), 1e-4 * std::max(1.0F, std::abs(plain(r, c))));
  fs::remove(path("o.exr"));
  expect_refused(glare("a1 = 1\n"), {"glare.toml", "\"b1\" is missing"});
  for (const char* a1 : {"0", "0.5", "9"})
    expect_refused(
        glare(std::string("a1 = ") + a1 + "\nb1 = 0\nc1 = 1e6\na2 = 0\nb2 = 0\nc2 = 1\n"),
        {"glare.toml", "rho = 0", "1"});
  expect_refused(glare("a1 = 1\nb1 = 0\nc1 = 0.1\na2 = 0\nb2 = 0\nc2 = 1\n"),
                 {"glare.toml", "0.05"});
  expect_refused(glare("a1 = -1\nb1 = 0\nc1 = 1\na2 = 0\nb2 = 0\nc2 = 1\n"), {"glare.toml"});
  expect_refused(glare("a1 = 1\nb1 = 0\nc1 = 0\na2 = 0\nb2 = 0\nc2 = 1\n"), {"\"c1\""});
  EXPECT_FALSE(fs::exists(path("o.exr")));
}

TEST_F(HdrCommands, ContradictoryStacksAreWarnedOf) {
  // Light of 1000 : 1 that saturates a 14-bit sensor in the longer frame.
  const auto write = [&](const std::string& name, double time_s) {
    MosaicImage m{cv::Mat1w(40, 60)};
    for (int r = 0; r < 40; ++r)
      for (int c = 0; c < 60; ++c)
        m.dn(r, c) = static_cast<std::uint16_t>(
            std::min(16383.0, 512 + 1000 * std::pow(1000, (r + c) / 98.0) * time_s));
    write_mosaic_png(path(name), m);
  };
  write("short.png", 0.01);
  write("long.png", 0.04);
  const json good = {{"pattern", "RGGB"},
                     {"bits", 14},
                     {"black", 512},
                     {"frames",
                      {{{"file", "short.png"}, {"exposure_s", 0.01}},
                       {{"file", "long.png"}, {"exposure_s", 0.04}}}}};
  const auto warnings = [&](const std::string& pointer, const json& value) {
    json document = good;
    if (!pointer.empty()) document[json::json_pointer(pointer)] = value;
    store(document);
    const Outcome outcome = merge();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  const auto named =
      testing::AllOf(testing::HasSubstr("warning: "), testing::HasSubstr(path("short.png")),
                     testing::HasSubstr(path("long.png")));
  EXPECT_THAT(warnings("", {}), testing::Not(testing::HasSubstr("warning")));
  EXPECT_THAT(warnings("/frames/0/exposure_s", 0.16), named);
  EXPECT_THAT(warnings("/frames/1/gain", 100), named);
  EXPECT_THAT(warnings("/black", 0), named);
  EXPECT_THAT(warnings("/bits", 16),
              testing::AllOf(testing::HasSubstr("warning: "), testing::HasSubstr("long.png"),
                             testing::HasSubstr("16383")));
  fs::remove(path("o.exr"));
  json twice = good;
  for (const char* again : {"short.png", "./short.png", "link.png"}) {
    if (again == std::string("link.png")) fs::create_symlink("short.png", path("link.png"));
    twice["frames"][1]["file"] = again;
    expect_merge_refused(twice, {path("frames.json"), "frames[1].file", "frames[0] too"});
  }
}

TEST_F(HdrCommands, MergedColoursAreTheDemosaicedMosaic) {
  const json file = vectors("merge_stacks.json");
  json document = write_stack(file["cases"][1], "poisson");
  document.erase("noise");
  document.erase("estimator");
  document.erase("saturation");
  store(document);
  const Outcome outcome = merge();
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("no sigma.Y"));
  ASSERT_EQ(run_program({"merge", "--frames", path("frames.json"), "--no-demosaic", "--out",
                         path("mosaic.exr")})
                .status,
            0);
  ASSERT_EQ(run_program({"demosaic", "--input", path("mosaic.exr"), "--pattern", "RGGB", "--out",
                         path("colour.exr")})
                .status,
            0);
  const auto merged = read_exr_views(path("o.exr"))[0].channels;
  const auto colour = read_exr_views(path("colour.exr"))[0].channels;
  EXPECT_FALSE(merged.contains("sigma.Y"));
  EXPECT_FALSE(merged.contains("mask.underexposed"));
  EXPECT_TRUE(merged.contains("mask.single_source"));
  for (const char* c : {"R", "G", "B"})
    EXPECT_EQ(cv::norm(merged.at(c).pixels, colour.at(c).pixels, cv::NORM_INF), 0) << c;
}

TEST_F(HdrCommands, DemosaicAgreesWithTheVectors) {
  const json file = vectors("demosaic.json");
  for (const auto& v : file["cases"]) {
    ScalarImage mosaic(v["cols"].get<int>(), v["rows"].get<int>());
    for (int r = 0; r < mosaic.height(); ++r)
      for (int c = 0; c < mosaic.width(); ++c) mosaic.pixels(r, c) = v["mosaic"][r][c];
    write_exr(path("m.exr"), mosaic, "Y");
    for (const bool refine : {true, false}) {
      std::vector<std::string> arguments = {"demosaic",   "--input", path("m.exr"), "--pattern",
                                            v["pattern"], "--out",   path("o.exr")};
      if (!refine) arguments.emplace_back("--no-refine");
      const Outcome outcome = run_program(arguments);
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      const auto channels = read_exr_views(path("o.exr"))[0].channels;
      const json& expected = v[refine ? "menon2007" : "menon2007_without_refinement"];
      double worst = 0, peak = 1;
      for (int r = 0; r < mosaic.height(); ++r)
        for (int c = 0; c < mosaic.width(); ++c)
          for (int k = 0; k < 3; ++k) {
            const double e = expected[r][c][k];
            peak = std::max(peak, e);
            worst =
                std::max(worst, std::abs(channels.at(std::string(1, "RGB"[k])).pixels(r, c) - e));
          }
      EXPECT_LT(worst, 1e-6 * peak) << v["name"];
    }
  }
}

TEST_F(HdrCommands, EstimatesTimesAsJson) {
  const json file = vectors("exposure_estimation.json");
  const json& v = file["cases"][0];
  json frames = json::array();
  for (std::size_t i = 0; i < v["files"].size(); ++i)
    frames.push_back({{"file", kVectors + v["files"][i].get<std::string>()},
                      {"exposure_s", v["nominal_exposure_s"][i]}});
  store({{"pattern", "RGGB"}, {"bits", 14}, {"black", 512}, {"frames", frames}});
  const Outcome outcome = run_program({"estimate-exposures", "--frames", path("frames.json"),
                                       "--method", "mst", "--weighted", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json out = json::parse(outcome.out);
  for (std::size_t i = 0; i < 4; ++i) {
    const double truth = v["true_exposure_s"][i];
    EXPECT_NEAR(out["exposure_s"][i].get<double>(), truth, 0.003 * truth);
    EXPECT_TRUE(out["estimated"][i].get<bool>());
  }
  expect_refused(run_program({"estimate-exposures", "--frames", path("frames.json"), "--method",
                              "histogram", "--json"}),
                 {"histogram", "pairwise or mst"});
}

TEST_F(HdrCommands, BadStacksAreRefused) {
  const json file = vectors("merge_stacks.json");
  const json good = write_stack(file["cases"][0], "poisson");
  const std::string stack = path("frames.json");
  const auto without = [&](const std::string& key) {
    json document = good;
    document.erase(key);
    return document;
  };
  const auto with = [&](const std::string& pointer, const json& value) {
    json document = good;
    document[json::json_pointer(pointer)] = value;
    return document;
  };
  for (const char* key : {"pattern", "bits", "black", "frames"})
    expect_merge_refused(without(key), {stack, key, "missing"});
  json no_noise = without("noise");
  no_noise["estimator"] = "full";
  expect_merge_refused(no_noise, {stack, "noise", "full"});
  expect_merge_refused(with("/estimator", "debevec"), {stack, "debevec", "poisson or full"});
  expect_merge_refused(with("/pattern", "RGBG"), {stack, "RGBG", "GBRG"});
  expect_merge_refused(with("/exposures", 3), {stack, "exposures"});
  expect_merge_refused(with("/frames/1/exposure", 3), {stack, "frames[1].exposure"});
  expect_merge_refused(with("/noise/sigma", 3), {stack, "noise.sigma"});
  expect_merge_refused(with("/noise/std_adc", -1), {stack, "noise.std_adc"});
  expect_merge_refused(with("/bits", 17), {stack, "bits", "16"});
  json few_bits = without("saturation");
  few_bits["bits"] = 10;
  expect_merge_refused(few_bits, {"frame_", "10 bits"});
  expect_merge_refused(with("/black", 20000), {stack, "black"});
  expect_merge_refused(with("/frames", json::array()), {stack, "frames"});
  for (const json& time : {json(0), json(-1), json("1/60"), json(nullptr)})
    expect_merge_refused(with("/frames/1/exposure_s", time), {stack, "frames[1].exposure_s"});
  json no_time = good;
  no_time["frames"][2].erase("exposure_s");
  expect_merge_refused(no_time, {stack, "frames[2].exposure_s", "missing"});
  expect_merge_refused(with("/frames/1/exposure_s", good["frames"][0]["exposure_s"]),
                       {stack, "exposure 1", "same time"});
  expect_merge_refused(with("/frames/1/file", "nowhere.png"), {path("nowhere.png"), "missing"});
  std::ofstream(path("frames.json")) << R"({"pattern": "RGGB", "bits": NaN})";
  expect_refused(merge(), {stack, "JSON"});
  expect_refused(run_program({"merge", "--frames", path("none.json"), "--out", path("o.exr")}),
                 {path("none.json"), "missing"});
  EXPECT_EQ(run_program({"merge"}).status, 1);
}

TEST_F(HdrCommands, DamagedFramesAreRefused) {
  const json file = vectors("merge_stacks.json");
  const json good = write_stack(file["cases"][0], "poisson");
  fs::resize_file(path("frame_1.png"), fs::file_size(path("frame_1.png")) / 2);
  expect_merge_refused(good, {path("frame_1.png")});
  write_mosaic_png(path("frame_1.png"), {cv::Mat1w(4, 4, std::uint16_t{600})});
  expect_merge_refused(good, {path("frame_1.png"), "4 x 4"});
  write_drive_png(path("frame_1.png"), {cv::Mat1b(8, 12, std::uint8_t{9})});
  expect_merge_refused(good, {path("frame_1.png"), "16-bit"});
  for (const char* header :
       {"P5\n12 8\n65535\n", "P5\n1000000 1000000\n65535\n", "P5\n-3 8\n", "P5"}) {
    std::ofstream(path("frame_1.pgm")) << header << "abcdefgh";
    json document = good;
    document["frames"][1]["file"] = "frame_1.pgm";
    expect_merge_refused(document, {path("frame_1.pgm")});
  }
}

TEST_F(HdrCommands, AFailedRunLeavesTheOldFile) {
  const json file = vectors("merge_stacks.json");
  json document = write_stack(file["cases"][0], "poisson");
  ASSERT_EQ(merge().status, 0);
  const auto before = read_bytes(path("o.exr"));
  document["frames"][1]["exposure_s"] = 0;
  store(document);
  expect_refused(merge(), {"exposure_s"});
  EXPECT_TRUE(read_bytes(path("o.exr")) == before);
  document["frames"][1]["exposure_s"] = 0.07;
  store(document);
  expect_refused(
      run_program({"merge", "--frames", path("frames.json"), "--out", path("nowhere/o.exr")}),
      {path("nowhere/o.exr"), "folder"});
}

TEST_F(HdrCommands, BadMosaicsAreRefused) {
  const auto refused = [&](const std::string& input, const std::vector<std::string>& parts) {
    expect_refused(
        run_program({"demosaic", "--input", input, "--pattern", "RGGB", "--out", path("o.exr")}),
        parts);
    EXPECT_FALSE(fs::exists(path("o.exr")));
    expect_nothing_half_written(root_);
  };
  ScalarImage mosaic(6, 4, 1);
  mosaic.pixels(2, 3) = std::nanf("");
  write_exr(path("nan.exr"), mosaic, "Y");
  refused(path("nan.exr"), {path("nan.exr"), "column 3", "row 2"});
  write_exr(path("rgb.exr"), RgbImage(6, 4));
  refused(path("rgb.exr"), {path("rgb.exr"), "3 channels"});
  write_exr(path("line.exr"), ScalarImage(6, 1, 1), "Y");
  refused(path("line.exr"), {"6 x 1"});
  refused(path("nowhere.exr"), {path("nowhere.exr")});
  std::ofstream(path("text.png")) << "no picture";
  refused(path("text.png"), {path("text.png")});
  write_exr(path("ok.exr"), ScalarImage(6, 4, 1), "Y");
  expect_refused(run_program({"demosaic", "--input", path("ok.exr"), "--pattern", "RGGB", "--out",
                              path(".") + "/ok.exr"}),
                 {"is read from, and would be overwritten"});
  expect_refused(run_program({"demosaic", "--input", path("ok.exr"), "--pattern", "RGGB", "--out",
                              path("o.png")}),
                 {path("o.png"), "let the name end in .exr"});
  expect_refused(run_program({"demosaic", "--input", path("ok.exr"), "--pattern", "XTRANS", "--out",
                              path("o.exr")}),
                 {"XTRANS", "RGGB"});
}

}  // namespace
}  // namespace wheatstone::apps
