// `wheatstone metric` as a person uses it: every input format, one pair and folders, and what it
// refuses.
#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/csv.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/hdr_files.h"
#include "core/png.h"
#include "program.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/viewing.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

const fs::path kVectors = fs::path(WHEATSTONE_SOURCE_DIR) / "tests/vectors/metrics";

class Metric : public TemporaryFolder {
 protected:
  std::vector<std::string> command(const std::string& test, const std::string& reference,
                                   const std::string& metric,
                                   std::vector<std::string> more = {}) const {
    std::vector<std::string> out = {"metric",  "--test",   test,  "--reference",
                                    reference, "--metric", metric};
    out.insert(out.end(), more.begin(), more.end());
    return out;
  }
  json scored(const std::vector<std::string>& arguments) const {
    std::vector<std::string> with_json = arguments;
    with_json.emplace_back("--json");
    const Outcome outcome = run_program(with_json);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.status == 0 ? json::parse(outcome.out) : json();
  }
  void refused(const std::vector<std::string>& arguments, std::vector<std::string> parts) const {
    const Outcome outcome = run_program(arguments);
    expect_refused(outcome, parts);
    EXPECT_EQ(outcome.out, "");  // no number beside the error
  }
  /// Links vector images into a folder under the names of the reference's pairs.
  void fill(const std::string& folder,
            std::initializer_list<std::pair<const char*, const char*>> as) {
    fs::create_directories(path(folder));
    for (const auto& [name, vector] : as)
      fs::copy_file(image(vector), path(folder + "/" + name + ".pfm"));
  }
  static std::string image(const std::string& name) { return kVectors / "img" / (name + ".pfm"); }
};

TEST_F(Metric, ReferenceVectors) {
  const json file = json::parse(read_text(kVectors / "pu21_metrics.json"));
  for (const json& c : file["cases"]) {
    const std::string test = kVectors / c["test"].get<std::string>(),
                      reference = kVectors / c["reference"].get<std::string>();
    const auto value = [&](const char* metric, const char* channel) {
      return scored(command(test, reference, metric, {"--channel", channel, "--absolute"}))["value"]
          .get<double>();
    };
    EXPECT_NEAR(value("pu21-psnr", "rgb"), c["pu_psnr_rgb_db"].get<double>(), 1e-4);
    EXPECT_NEAR(value("pu21-psnr", "y"), c["pu_psnr_luminance_db"].get<double>(), 1e-4);
    EXPECT_NEAR(value("pu21-ssim", "y"), c["pu_ssim_luminance"].get<double>(), 1e-6);
  }
}

TEST_F(Metric, HdrVdp3WithItsMap) {
  const json vdp = scored(command(image("a_patch"), image("a_ref"), "hdr-vdp3",
                                  {"--absolute", "--ppd", "45", "--map", path("map.exr")}));
  EXPECT_EQ(vdp["value"], vdp["Q_JOD"]);
  EXPECT_GT(vdp["P_det"], 0);
  EXPECT_EQ(vdp["unit"], "JOD");
  const auto views = read_exr_views(path("map.exr"));
  EXPECT_EQ(views.at(0).channels.at("p_det").width(), 160);
  // The same visual angle given by pixel pitch and distance.
  const double pitch_mm = 2 * 500 * std::tan(0.5 / 45 * 3.14159265358979 / 180);
  EXPECT_NEAR(scored(command(image("a_patch"), image("a_ref"), "hdr-vdp3",
                             {"--absolute", "--pixel-pitch-mm", std::to_string(pitch_mm),
                              "--distance-mm", "500"}))["value"]
                  .get<double>(),
              vdp["value"].get<double>(), 1e-3);
}

TEST_F(Metric, EveryFormatGivesTheSameLight) {
  const RgbImage light = read_pfm(image("a_noise05"));
  RgbImage relative(light.pixels.clone());
  relative.pixels /= 4000;
  write_exr(path("absolute.exr"), light);  // states whiteLuminance 1
  cv::Mat bgr;
  cv::mixChannels(std::vector<cv::Mat>{relative.pixels},
                  std::vector<cv::Mat>{bgr = relative.pixels.clone()}, {0, 2, 1, 1, 2, 0});
  ASSERT_TRUE(cv::imwrite(path("relative.hdr"), bgr));
  ASSERT_TRUE(cv::imwrite(path("relative.pfm"), bgr));
  const double pfm =
      scored(command(image("a_noise05"), image("a_ref"), "pu21-psnr", {"--absolute"}))["value"];
  const auto against_reference = [&](const std::string& test, std::vector<std::string> more) {
    write_exr(path("reference.exr"), read_pfm(image("a_ref")));
    return scored(command(test, path("reference.exr"), "pu21-psnr", std::move(more)))["value"]
        .get<double>();
  };
  EXPECT_NEAR(against_reference(path("absolute.exr"), {}), pfm, 1e-6);
  EXPECT_NEAR(against_reference(path("relative.pfm"), {"--peak-cd-m2", "4000"}), pfm, 1e-3);
  EXPECT_NEAR(against_reference(path("relative.hdr"), {"--peak-cd-m2", "4000"}), pfm, 0.2);
}

TEST_F(Metric, IntegerPicturesGoThroughTheDisplayModel) {
  const GogDisplay display{200, 500, 2.4, 100, 0.01};
  RgbImage light(48, 32);
  for (const bool deep : {false, true}) {
    cv::Mat codes(32, 48, deep ? CV_16UC3 : CV_8UC3);
    for (int r = 0; r < 32; ++r)
      for (int c = 0; c < 48; ++c)
        for (int k = 0; k < 3; ++k) {
          const int code = (5 * c + 3 * r + 40 * k) % 256 * (deep ? 257 : 1);
          if (deep)
            codes.at<cv::Vec3w>(r, c)[2 - k] = static_cast<unsigned short>(code);
          else
            codes.at<cv::Vec3b>(r, c)[2 - k] = static_cast<unsigned char>(code);
          light.pixels(r, c)[k] =
              static_cast<float>(display.light_cd_m2(code / (deep ? 65535.0 : 255.0)));
        }
    write_exr(path("light.exr"), light);
    for (const char* name : {"codes.png", "codes.tiff"}) {
      ASSERT_TRUE(cv::imwrite(path(name), codes));
      const json out = scored(command(path(name), path("light.exr"), "pu21-psnr",
                                      {"--peak-cd-m2", "200", "--contrast", "500", "--gamma", "2.4",
                                       "--ambient-lux", "100", "--reflectivity", "0.01"}));
      EXPECT_EQ(out["value"], "inf");  // equal pictures, as JSON can say it
    }
  }
}

TEST_F(Metric, RegionsAndMasks) {
  const auto value = [&](std::vector<std::string> more) {
    more.emplace_back("--absolute");
    return scored(command(image("a_noise05"), image("a_ref"), "pu21-psnr", more))["value"];
  };
  cv::Mat1b mask(120, 160, static_cast<unsigned char>(0));
  mask(cv::Rect(20, 30, 50, 40)) = 255;
  ASSERT_TRUE(cv::imwrite(path("mask.png"), mask));
  EXPECT_NEAR(value({"--mask", path("mask.png")}).get<double>(),
              value({"--roi", "20,30,50,40"}).get<double>(), 1e-9);
  EXPECT_NEAR(value({"--mask", path("mask.png"), "--roi", "10,20,100,90"}).get<double>(),
              value({"--roi", "20,30,50,40"}).get<double>(), 1e-9);
}

TEST_F(Metric, MapsForMachinesAndForPeople) {
  for (const char* metric : {"pu21-psnr", "pu21-ssim"}) {
    EXPECT_EQ(run_program(command(image("a_patch"), image("a_ref"), metric,
                                  {"--absolute", "--map", path("map.png")}))
                  .status,
              0);
    EXPECT_EQ(cv::imread(path("map.png")).cols, 160);
    EXPECT_EQ(run_program(command(image("a_patch"), image("a_ref"), metric,
                                  {"--absolute", "--map", path("map.exr")}))
                  .status,
              0);
    EXPECT_EQ(read_exr_views(path("map.exr")).at(0).width_px, 160);
  }
}

TEST_F(Metric, FoldersPairByNameAndGiveMeanAndDeviation) {
  fill("test", {{"one", "a_noise05"}, {"two", "a_patch"}, {"same", "a_ref"}});
  fill("reference", {{"one", "a_ref"}, {"two", "a_ref"}, {"same", "a_ref"}});
  const auto arguments = command(path("test"), path("reference"), "pu21-psnr", {"--absolute"});
  const json out = scored(arguments);
  ASSERT_EQ(out["pairs"].size(), 3U);
  EXPECT_EQ(out["pairs"][0]["name"], "one");
  EXPECT_EQ(out["pairs"][1]["value"], "inf");  // "same"
  EXPECT_EQ(out["identical_pairs"], 1);
  const double a = 39.8847280521, b = 33.9245588066;  // pu21_metrics.json
  EXPECT_NEAR(out["mean"].get<double>(), (a + b) / 2, 1e-4);
  EXPECT_NEAR(out["standard_deviation"].get<double>(), (a - b) / std::sqrt(2), 1e-4);
  EXPECT_THAT(run_program(arguments).out, HasSubstr("36.9046 dB, standard deviation 4.2145"));
}

std::string all_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename()] = read_text(entry.path());
  return json(files).dump();
}

TEST_F(Metric, ShardsResumedAndSerialRunsWriteTheSameBytes) {
  fill("test", {{"a", "a_noise05"}, {"b", "a_patch"}, {"c", "a_blur20"}});
  fill("reference", {{"a", "a_ref"}, {"b", "a_ref"}, {"c", "a_ref"}});
  const auto run = [&](const std::string& out, std::vector<std::string> more) {
    more.insert(more.end(), {"--absolute", "--out", path(out)});
    const Outcome outcome =
        run_program(command(path("test"), path("reference"), "pu21-ssim", more));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  const std::string serial = run("serial", {});
  run("sharded", {"--shard", "2/2"});
  EXPECT_TRUE(fs::exists(path("sharded/b.json")));
  EXPECT_FALSE(fs::exists(path("sharded/a.json")));
  run("sharded", {"--shard", "1/2"});
  // A finished score is not made again: the picture is no longer needed.
  const std::string kept = read_text(path("test/b.pfm"));
  std::ofstream(path("test/b.pfm")) << "damaged since";
  EXPECT_EQ(run("sharded", {}), serial);
  std::ofstream(path("test/b.pfm"), std::ios::binary) << kept;
  fs::remove(path("sharded/c.json"));
  run("sharded", {});
  EXPECT_EQ(all_files(path("sharded")), all_files(path("serial")));
  expect_nothing_half_written(root_);
  refused(command(path("test"), path("reference"), "pu21-psnr",
                  {"--absolute", "--out", path("serial")}),
          {"serial/a.json", "other settings"});
}

TEST_F(Metric, FlickerOfASequence) {
  fill("test", {{"frame_0", "a_ref"}, {"frame_1", "a_noise05"}, {"frame_2", "a_ref"}});
  fill("reference", {{"frame_0", "a_ref"}, {"frame_1", "a_ref"}, {"frame_2", "a_ref"}});
  const json out = scored(command(path("test"), path("reference"), "flicker", {"--absolute"}));
  // Both steps are the noise; its PSNR is known.
  const double noise_pu = 256 / std::pow(10, 39.8847280521 / 20);
  EXPECT_NEAR(out["value"].get<double>(), noise_pu, 1e-3);
  EXPECT_EQ(out["frames"], 3);
}

TEST_F(Metric, Pu21Table) {
  const json file = json::parse(read_text(kVectors / "pu21_encode.json"));
  for (const auto& [variant, rows] : file["variants"].items()) {
    CsvTable in({"name", "luminance_cd_m2"});
    for (const json& row : rows) in.add_row({"x", std::to_string(row[0].get<double>())});
    std::vector<double> light;
    for (const json& row : rows) light.push_back(row[0]);
    in.set_column("luminance_cd_m2", light);
    in.write(path("in.csv"));
    const Outcome outcome = run_program({"metric", "pu21", "--variant", variant, "--input",
                                         path("in.csv"), "--output", path("out.csv")});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const CsvTable out = CsvTable::read(path("out.csv"));
    EXPECT_EQ(out.text(0, "name"), "x");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double encoded = rows[i][1], decoded = rows[i][2];
      EXPECT_NEAR(out.number(i, "pu21_value"), encoded, 2e-7 + 1e-9 * encoded);
      EXPECT_NEAR(out.number(i, "decoded_cd_m2"), decoded, 1e-7 * decoded);
    }
  }
}

TEST_F(Metric, Pu21TableOfImpossibleLightIsRefused) {
  for (const auto& [text, part] : std::initializer_list<std::pair<std::string, std::string>>{
           {"luminance\n1\n", "luminance_cd_m2"},
           {"luminance_cd_m2\n1\n-1\n", "in.csv:3"},
           {"luminance_cd_m2\n1\nnan\n", "in.csv:3"},
           {"luminance_cd_m2\nbright\n", "in.csv:2"},
           {"luminance_cd_m2\n", "no rows"}}) {
    std::ofstream(path("in.csv")) << text;
    refused({"metric", "pu21", "--input", path("in.csv"), "--output", path("out.csv")}, {part});
    EXPECT_FALSE(fs::exists(path("out.csv")));
  }
  std::ofstream(path("in.csv")) << "luminance_cd_m2\n1\n";
  refused({"metric", "pu21", "--variant", "bandig", "--input", path("in.csv"), "--output",
           path("out.csv")},
          {"bandig", "banding_glare"});
}

TEST_F(Metric, WithoutAScaleThereIsNoScore) {
  write_exr(path("map.exr"), ScalarImage(200, 180, 1), "Y");
  cv::imwrite(path("codes.png"), cv::Mat3b(120, 160, cv::Vec3b(9, 9, 9)));
  refused(command(image("a_noise05"), image("a_ref"), "pu21-psnr"),
          {"a_noise05.pfm", "cd/m²", "--absolute", "--peak-cd-m2"});
  refused(command(path("codes.png"), image("a_ref"), "pu21-psnr", {"--absolute"}),
          {"codes.png", "--peak-cd-m2"});
  refused(command(path("map.exr"), image("a_ref"), "pu21-psnr", {"--absolute"}), {"map.exr"});
  for (const char* bad : {"0", "-3", "nan", "inf"})
    refused(command(image("a_noise05"), image("a_ref"), "pu21-psnr", {"--peak-cd-m2", bad}),
            {"not positive"});
}

TEST_F(Metric, WhatCannotBeScoredIsRefused) {
  const auto a = [&](const std::string& metric, std::vector<std::string> more) {
    more.emplace_back("--absolute");
    return command(image("a_noise05"), image("a_ref"), metric, more);
  };
  refused(command(image("a_ref"), image("b_ref"), "pu21-ssim", {"--absolute"}),
          {"160x120", "256x192", "a_ref.pfm", "b_ref.pfm"});
  refused(a("ms-ssim", {}), {"160x120", "176x176"});
  refused(a("hdr-vdp3", {}), {"--ppd"});
  refused(a("hdr-vdp3", {"--ppd", "0"}), {"pixels per degree"});
  refused(a("hdr-vdp3", {"--ppd", "1e6"}), {"pixels per degree"});
  refused(a("hdr-vdp3", {"--ppd", "45", "--channel", "y"}), {"--channel"});
  refused(a("hdr-vdp3", {"--pixel-pitch-mm", "0.1"}), {"--distance-mm"});
  refused(a("pu21-ssim", {"--ppd", "45"}), {"pu21-ssim", "--ppd"});
  refused(a("pu21-psnr", {"--roi", "100,100,61,20"}), {"100,100,61,20", "160x120"});
  refused(a("pu21-psnr", {"--roi", "0,0,0,5"}), {"0,0,0,5"});
  refused(a("pu21-psnr", {"--map", path("map.jpg")}), {"map.jpg", ".exr"});
  refused(a("pu21-psnr", {"--out", path("scores")}), {"--out", "two folders"});
  refused(a("flicker", {}), {"folders"});
  refused(command(image("none"), image("a_ref"), "pu21-psnr", {"--absolute"}),
          {"none.pfm", "missing"});
  refused(command(root_.string(), image("a_ref"), "pu21-psnr", {"--absolute"}), {"folder"});
  cv::imwrite(path("mask.png"), cv::Mat1b(120, 160, static_cast<unsigned char>(0)));
  refused(a("pu21-ssim", {"--mask", path("mask.png")}), {"selects no pixel"});
  cv::imwrite(path("small.png"), cv::Mat1b(12, 16, static_cast<unsigned char>(1)));
  refused(a("pu21-ssim", {"--mask", path("small.png")}), {"16x12"});
  refused(a("hdr-vdp3", {"--ppd", "45", "--mask", path("small.png")}), {"--mask"});
  std::ofstream(path("notes.txt")) << "no picture";
  refused(command(path("notes.txt"), image("a_ref"), "pu21-psnr"), {"notes.txt", "format"});
  EXPECT_FALSE(fs::exists(path("map.jpg")));
  EXPECT_FALSE(fs::exists(path("scores")));
}

TEST_F(Metric, ImpossibleLightIsCountedAndLocated) {
  RgbImage light = read_pfm(image("a_ref"));
  const auto store = [&](float value) {
    std::ofstream out(path("bad.pfm"), std::ios::binary);
    out << "PF\n160 120\n-1\n";
    light.pixels(7, 11)[2] = value;
    for (int r = 119; r >= 0; --r)
      out.write(reinterpret_cast<const char*>(light.pixels[r]), 160 * 12);
  };
  for (const char* metric : {"pu21-psnr", "pu21-ssim", "hdr-vdp3"}) {
    std::vector<std::string> more = {"--absolute"};
    if (metric == std::string("hdr-vdp3")) more.insert(more.end(), {"--ppd", "45"});
    for (const auto& [value, part] :
         {std::pair{-1.0F, "1 negative"}, {NAN, "1 NaN"}, {INFINITY, "1 infinite"}}) {
      store(value);
      refused(command(path("bad.pfm"), image("a_ref"), metric, more),
              {"bad.pfm", part, "column 11, row 7"});
    }
    std::ofstream(path("black.pfm"), std::ios::binary) << "PF\n160 120\n-1\n"
                                                       << std::string(160 * 120 * 12, '\0');
    refused(command(path("black.pfm"), image("a_ref"), metric, more), {"black.pfm", "black"});
  }
}

TEST_F(Metric, FoldersThatDoNotMatchAreRefused) {
  fill("test", {{"one", "a_noise05"}, {"two", "a_patch"}});
  fill("reference", {{"one", "a_ref"}});
  fill("empty", {});
  const auto folders = [&](const std::string& test, const std::string& reference,
                           std::vector<std::string> more = {}) {
    more.emplace_back("--absolute");
    return command(path(test), path(reference), "pu21-psnr", more);
  };
  refused(folders("test", "reference"), {"two.pfm", "no partner"});
  refused(folders("reference", "test"), {"two.pfm", "no partner"});
  refused(folders("empty", "reference"), {"empty", "no picture"});
  fs::copy_file(image("a_ref"), path("reference/two.pfm"));
  for (const char* shard : {"0/2", "3/2", "1", "1/2x", "-1/2", "a/b"})
    refused(folders("test", "reference", {"--out", path("scores"), "--shard", shard}), {shard});
  refused(folders("test", "reference", {"--shard", "1/2"}), {"--out"});
  refused(folders("test", "reference", {"--map", path("map.png")}), {"--map"});
  EXPECT_FALSE(fs::exists(path("scores")));
  write_exr(path("test/two.exr"), read_pfm(image("a_ref")));
  refused(folders("test", "reference"), {"two", "same name"});
}

TEST_F(Metric, UnknownWordsAreRefusedByTheParser) {
  for (const auto& arguments :
       {command(image("a_ref"), image("a_ref"), "vmaf", {"--absolute"}),
        command(image("a_ref"), image("a_ref"), "pu21-psnr", {"--channel", "xyz"}),
        command(image("a_ref"), image("a_ref"), "pu21-psnr", {"--roi", "1,2,3"}),
        std::vector<std::string>{"metric", "--test", image("a_ref"), "--metric", "pu21-psnr"}}) {
    const Outcome outcome = run_program(arguments);
    EXPECT_NE(outcome.status, 0);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err, "");
  }
}

}  // namespace
}  // namespace wheatstone::apps
