// `wheatstone quality`: the reference vectors through the program, and what it says to bad input.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/csv.h"
#include "core/exr.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;

CsvTable vectors(const std::string& name) {
  return CsvTable::read(fs::path(WHEATSTONE_SOURCE_DIR) / "tests/vectors/motion_quality" / name);
}

/// The columns and the first rows of a table, without those that hold results.
CsvTable inputs_of(const CsvTable& t, const std::vector<std::string>& columns,
                   std::size_t rows = 1000) {
  CsvTable out(columns);
  for (std::size_t i = 0; i < std::min(rows, t.rows()); ++i) {
    std::vector<std::string> cells;
    for (const std::string& column : columns) cells.push_back(t.text(i, column));
    out.add_row(std::move(cells));
  }
  return out;
}

class Quality : public TemporaryFolder {
 protected:
  /// Runs on "in.csv" and returns the table written.
  CsvTable run(std::vector<std::string> arguments, const CsvTable& input) {
    input.write(path("in.csv"));
    for (const char* more : {"--input", "in.csv", "--output", "out.csv"})
      arguments.push_back(more[0] == '-' ? more : path(more));
    arguments.insert(arguments.begin(), "quality");
    const Outcome outcome = run_program(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return CsvTable::read(path("out.csv"));
  }
  /// Runs on the text as "bad.csv" and expects a refusal that writes nothing.
  void expect_table_refused(std::vector<std::string> arguments, const std::string& text,
                            const std::vector<std::string>& parts) {
    std::ofstream(path("bad.csv")) << text;
    arguments.insert(arguments.begin(), "quality");
    arguments.insert(arguments.end(), {"--input", path("bad.csv"), "--output", path("none.csv")});
    expect_refused(run_program(arguments), parts);
    EXPECT_FALSE(fs::exists(path("none.csv")));
    expect_nothing_half_written(root_);
  }
};

/// Every input cell of `out` as it was given, in the same order of rows and columns.
void expect_inputs_kept(const CsvTable& out, const CsvTable& in) {
  ASSERT_EQ(out.rows(), in.rows());
  for (std::size_t c = 0; c < in.columns().size(); ++c)
    EXPECT_EQ(out.columns()[c], in.columns()[c]);
  for (std::size_t i = 0; i < in.rows(); ++i)
    for (const std::string& column : in.columns())
      EXPECT_EQ(out.text(i, column), in.text(i, column));
}

TEST_F(Quality, CsfLikeTheReference) {
  const struct {
    const char *model, *file, *expected;
    std::vector<std::string> columns;
  } cases[] = {
      {"barten", "csf_barten.csv", "S", {"u_cpd", "L_cd_m2", "X0_deg"}},
      {"kelly", "csf_kelly_released.csv", "S_released", {"rho_cpd", "omega_hz"}},
      {"velocity", "csf_daly.csv", "S", {"rho_cpd", "velocity_deg_s"}},
      {"static", "csf_spatiotemporal.csv", "S_static", {"rho_cpd", "L_cd_m2"}},
      {"spatiotemporal", "csf_spatiotemporal.csv", "S", {"rho_cpd", "omega_hz", "L_cd_m2"}}};
  for (const auto& c : cases) {
    const CsvTable reference = vectors(c.file), input = inputs_of(reference, c.columns),
                   out = run({"csf", "--model", c.model}, input);
    expect_inputs_kept(out, input);
    for (std::size_t i = 0; i < out.rows(); ++i) {
      const double expected = reference.number(i, c.expected), s = out.number(i, "S");
      if (std::isnan(expected))
        EXPECT_TRUE(std::isnan(s)) << c.model << " row " << i;
      else
        EXPECT_NEAR(s, expected, 1e-9 * std::abs(expected)) << c.model << " row " << i;
    }
  }
}

const std::vector<std::string> kMarrrColumns = {
    "refreshA_hz", "resolution_reductionA", "refreshB_hz", "native_width_px",
    "fov_deg",     "velocity_deg_s",        "predictable", "persistence"};

TEST_F(Quality, MarrrLikeTheReference) {
  const CsvTable reference = vectors("marrr_quality.csv"),
                 input = inputs_of(reference, kMarrrColumns);
  for (const auto& [preset, column] :
       {std::pair{"released", "Q_released"}, {"published", "Q_thesis_pa_pb_9freq"}}) {
    const CsvTable out = run({"marrr", "--preset", preset}, input);
    expect_inputs_kept(out, input);
    for (std::size_t i = 0; i < out.rows(); ++i)
      EXPECT_NEAR(out.number(i, "Q"), reference.number(i, column), 1e-9) << preset << " row " << i;
  }
}

TEST_F(Quality, MarrrOptimumReachesTheReference) {
  const CsvTable reference = vectors("marrr_optimum.csv"),
                 out = run(
                     {"marrr-optimum"},
                     inputs_of(reference, {"bandwidth_fraction", "velocity_deg_s", "predictable"}));
  for (std::size_t i = 0; i < out.rows(); ++i)
    EXPECT_NEAR(out.number(i, "Q_vs_reference"), reference.number(i, "Q_vs_reference"), 1e-9);
}

const std::vector<std::string> kCamojabColumns = {"texture",        "ppd",         "refresh_hz",
                                                  "velocity_deg_s", "persistence", "mean_lum_cd_m2",
                                                  "mip_level",      "srx",         "sry"};

TEST_F(Quality, CamojabLikeTheReference) {
  for (const auto& [preset, file] : {std::pair{"released", "camojab_vectors.csv"},
                                     {"published", "camojab_published_vectors.csv"}}) {
    const CsvTable reference = vectors(file), input = inputs_of(reference, kCamojabColumns, 4),
                   out = run({"camojab", "--texture", "procedural:checker512", "--preset", preset},
                             input);
    expect_inputs_kept(out, input);
    for (std::size_t i = 0; i < out.rows(); ++i) {
      ASSERT_EQ(input.text(i, "texture"), "checker512");
      EXPECT_NEAR(out.number(i, "Ds"), reference.number(i, "Ds"), 1.1e-4) << preset;
      EXPECT_NEAR(out.number(i, "Dt"), reference.number(i, "Dt"), 2.1e-5) << preset;
      EXPECT_NEAR(out.number(i, "Q"), reference.number(i, "Q"), 5e-4) << preset;
    }
  }
}

TEST_F(Quality, ResultsAlreadyThereAreReplacedAndPrintAsJson) {
  CsvTable input({"u_cpd", "S", "L_cd_m2", "X0_deg", "note"});
  input.add_row({"1", "old", "100", "10", "one, quoted"});
  input.write(path("in.csv"));
  const Outcome outcome = run_program({"quality", "csf", "--model", "barten", "--input",
                                       path("in.csv"), "--output", path("out.csv"), "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const CsvTable out = CsvTable::read(path("out.csv"));
  EXPECT_EQ(out.columns(), input.columns());
  EXPECT_GT(out.number(0, "S"), 100);
  const auto rows = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0]["S"], out.number(0, "S"));
  EXPECT_EQ(rows[0]["note"], "one, quoted");
}

TEST_F(Quality, CsfInputThatIsNoFrequency) {
  const std::vector<std::string> kelly = {"csf", "--model", "kelly"};
  expect_table_refused(kelly, "rho_cpd,omega_hz\n1,30\n-1,30\n", {path("bad.csv:3"), "-1"});
  expect_table_refused(kelly, "rho_cpd,omega_hz\n1,30\n1,inf\n", {path("bad.csv:3"), "omega_hz"});
  expect_table_refused(kelly, "rho_cpd,omega_hz\n1,fast\n", {path("bad.csv:2"), "fast"});
  expect_table_refused(kelly, "rho_cpd,omega_hz\n1,30\n1\n", {path("bad.csv"), "line 3"});
  expect_table_refused(kelly, "rho_cpd,speed\n1,30\n", {path("bad.csv"), "omega_hz"});
  expect_table_refused(kelly, "", {path("bad.csv"), "empty"});
  expect_table_refused({"csf", "--model", "static"}, "rho_cpd,L_cd_m2\n1,0\n",
                       {path("bad.csv:2"), "luminance"});
  expect_table_refused({"csf", "--model", "Barten"}, "u_cpd\n1\n", {"Barten", "spatiotemporal"});
  expect_refused(run_program({"quality", "csf", "--model", "kelly", "--input", path("nowhere.csv"),
                              "--output", path("none.csv")}),
                 {path("nowhere.csv")});
}

TEST_F(Quality, MarrrInputThatIsNoDisplay) {
  const std::vector<std::string> good = {"60", "0.5", "60", "2560", "30", "15", "1", "1"};
  const struct {
    std::size_t column;
    const char *value, *part;
  } cases[] = {
      {0, "0", "refresh"},       {1, "0", "resolution_reductionA"}, {1, "1.5", "above 1"},
      {2, "-60", "refresh"},     {3, "0", "native_width_px"},       {4, "0", "fov_deg"},
      {5, "-1", "speed"},        {6, "2", "predictable"},           {7, "0", "persistence"},
      {7, "1.1", "persistence"}, {5, "nan", "velocity_deg_s"}};
  for (const auto& c : cases) {
    CsvTable t(kMarrrColumns);
    t.add_row(good);
    std::vector<std::string> bad = good;
    bad[c.column] = c.value;
    t.add_row(bad);
    t.write(path("in.csv"));
    expect_refused(
        run_program({"quality", "marrr", "--input", path("in.csv"), "--output", path("none.csv")}),
        {path("in.csv:3"), c.part});
    EXPECT_FALSE(fs::exists(path("none.csv")));
  }
  expect_refused(run_program({"quality", "marrr", "--preset", "thesis", "--input", path("in.csv"),
                              "--output", path("none.csv")}),
                 {"thesis", "released", "published"});
}

TEST_F(Quality, CamojabInputThatCannotBeShown) {
  const std::vector<std::string> arguments = {"camojab", "--texture", "procedural:gradient256"};
  const std::string header =
      "ppd,refresh_hz,velocity_deg_s,persistence,mean_lum_cd_m2,mip_level,srx,sry\n"
      "60,60,15,1,150,2,1,1\n";
  const std::pair<const char*, const char*> rows[] = {{"0,60,15,1,150,2,1,1", "ppd"},
                                                      {"60,0,15,1,150,2,1,1", "refresh"},
                                                      {"60,60,-1,1,150,2,1,1", "speed"},
                                                      {"60,60,15,0,150,2,1,1", "persistence"},
                                                      {"60,60,15,1.5,150,2,1,1", "persistence"},
                                                      {"60,60,15,1,0,2,1,1", "luminance"},
                                                      {"60,60,15,1,150,-1,1,1", "mip level"},
                                                      {"60,60,15,1,150,2,0,1", "shading rate"},
                                                      {"60,60,15,1,150,2,1,1.2", "shading rate"},
                                                      {"60,60,15,1,150,nan,1,1", "mip_level"}};
  for (const auto& [row, part] : rows)
    expect_table_refused(arguments, header + row + "\n", {path("bad.csv:3"), part});
  expect_table_refused({"camojab", "--texture", "procedural:marble"}, header,
                       {"marble", "checker512"});
  expect_table_refused({"camojab", "--texture", path("missing.png")}, header,
                       {path("missing.png")});
  std::ofstream(path("text.png")) << "no picture";
  expect_table_refused({"camojab", "--texture", path("text.png")}, header, {path("text.png")});
  ScalarImage bad(4, 3, 0.5f);
  bad.pixels(2, 1) = std::numeric_limits<float>::infinity();
  write_exr(path("infinite.exr"), bad, "Y");
  expect_table_refused({"camojab", "--texture", path("infinite.exr")}, header,
                       {path("infinite.exr"), "column 1, row 2"});
}

TEST_F(Quality, TablesAskForTheirData) {
  for (const char* table : {"table-5-3", "ablation", "fit"}) {
    expect_refused(run_program({"quality", table}, {{"WHEATSTONE_SHARED=/nonexistent"}, {}}),
                   {"--data", "WHEATSTONE_SHARED"});
    expect_refused(run_program({"quality", table, "--data", path("nowhere"), "--textures", "."}),
                   {path("nowhere")});
  }
}

TEST_F(Quality, PlotsWithoutData) {
  for (const char* preset : {"released", "published"}) {
    ASSERT_EQ(
        run_program({"quality", "plot", "3.4", "--preset", preset, "--output", path("figure.svg")})
            .status,
        0);
    std::ifstream in(path("figure.svg"));
    const std::string svg((std::istreambuf_iterator<char>(in)), {});
    EXPECT_THAT(svg, ::testing::HasSubstr("best refresh rate (Hz)"));
    EXPECT_THAT(svg, ::testing::HasSubstr("</svg>"));
  }
  expect_refused(run_program({"quality", "plot", "9.9", "--output", path("none.svg")}), {"9.9"});
  expect_refused(run_program({"quality", "plot", "5.6", "--output", path("none.svg")},
                             {{"WHEATSTONE_SHARED=/nonexistent"}, {}}),
                 {"--data"});
  EXPECT_FALSE(fs::exists(path("none.svg")));
}

TEST_F(Quality, EverySubcommandShowsAnExample) {
  for (const char* command :
       {"csf", "marrr", "marrr-optimum", "camojab", "table-5-3", "ablation", "fit", "plot"}) {
    const Outcome outcome = run_program({"quality", command, "--help"});
    EXPECT_EQ(outcome.status, 0) << command;
    EXPECT_THAT(outcome.out, ::testing::HasSubstr("Example:")) << command;
  }
}

}  // namespace
}  // namespace wheatstone::apps
