#include "apps/plot.h"

#include <gmock/gmock.h>

#include <limits>
#include <set>

#include "core/error.h"
#include "core/files.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Plot, PlacesPointsOnItsScale) {
  Plot plot("t", {"x", false, std::pair{0.0, 10.0}}, {"y", false, std::pair{0.0, 1.0}});
  plot.points("p", {0, 10}, {0, 1});
  plot.hide_legend();
  const std::string svg = plot.svg(300, 200);
  // The frame is 62..284 wide and 30..152 high; y grows upwards.
  EXPECT_THAT(svg, HasSubstr("cx=\"62.00\" cy=\"152.00\""));
  EXPECT_THAT(svg, HasSubstr("cx=\"284.00\" cy=\"30.00\""));
}

TEST(Plot, LogarithmicAxisSpacesOctavesEvenly) {
  Plot plot("t", {"x", true, std::pair{1.0, 4.0}}, {"y"});
  plot.points("p", {1, 2, 4}, {0, 0, 0});
  plot.hide_legend();
  const std::string svg = plot.svg(300, 200);
  EXPECT_THAT(svg, HasSubstr("cx=\"173.00\""));  // midway between 62 and 284
}

TEST(Plot, MarksTheChosenTicksInsideItsRange) {
  Plot plot("t", {"x", true, std::pair{0.2, 1.2}, {0.125, 0.25, 0.5, 1}}, {"y"});
  plot.line("l", {0.25, 1}, {0, 1});
  const std::string svg = plot.svg(300, 200);
  EXPECT_THAT(svg, HasSubstr(">0.25</text>"));
  EXPECT_THAT(svg, Not(HasSubstr(">0.125</text>")));
}

TEST(Plot, LabelsUnitsTicksAndNames) {
  Plot plot("speed & <rate>", {"refresh rate (Hz)"}, {"quality (JND)"});
  plot.line("60 ppd", {50, 100, 150}, {0, 1, 2});
  plot.points("60 ppd", {50, 100, 150}, {0, 1, 2}, {-1, 0, 1}, {1, 2, 3});
  plot.line("30 ppd", {50, 150}, {-1, 1});
  std::string svg = plot.svg(300, 200);
  for (const char* part : {"speed &amp; &lt;rate&gt;", "refresh rate (Hz)", "quality (JND)",
                           ">100</text>", ">30 ppd</text>"})
    EXPECT_THAT(svg, HasSubstr(part));
  EXPECT_EQ(count_of(svg, ">60 ppd</text>"), 1);  // line and points share an entry
  EXPECT_EQ(count_of(svg, "<circle"), 3);
  EXPECT_EQ(count_of(svg, "class=\"line\""), 2);
  plot.hide_legend();
  EXPECT_THAT(plot.svg(300, 200), Not(HasSubstr(">60 ppd</text>")));
}

TEST(Plot, WideTickLabelsGetRoom) {
  Plot plot("t", {"x", false, std::pair{0.0, 1.0}}, {"y", false, std::pair{-0.00012, 0.00012}});
  plot.points("p", {0}, {0});
  plot.hide_legend();
  // "-0.0001" takes 7 characters, so that the frame begins further right than at 62.
  EXPECT_THAT(plot.svg(300, 200), Not(HasSubstr("cx=\"62.00\"")));
}

TEST(Plot, NoTwoNamesLookAlike) {
  for (const int names : {1, 7, 8, 12, 40}) {
    Plot plot("t", {"x"}, {"y"});
    for (int i = 0; i < names; ++i)
      plot.line("line " + std::to_string(i), {0, 1}, {1.0 * i, 1.0 * i});
    const std::string svg = plot.svg(460, 340);
    std::set<std::string> colours;
    const std::string before = "class=\"line\" stroke=\"";
    for (auto at = svg.find(before); at != std::string::npos; at = svg.find(before, at + 1))
      colours.insert(svg.substr(at + before.size(), 7));
    EXPECT_EQ(colours.size(), names);
    // The legend stays within the panel, and has the first name in any case.
    EXPECT_LE(count_of(svg, "class=\"key\""), 16);
    EXPECT_EQ(count_of(svg, ">line 0</text>"), 1);
    EXPECT_EQ(count_of(svg, "class=\"key\""), names <= 16 ? names : 14);
  }
}

TEST(Plot, RefusesWhatCannotBeDrawn) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Plot plot("t", {"x", true}, {"y"});
  EXPECT_THROW(plot.svg(300, 200), ArgumentError);
  EXPECT_THROW(plot.line("l", {}, {}), ArgumentError);
  EXPECT_THROW(plot.line("l", {1, 2}, {1}), ArgumentError);
  EXPECT_THROW(plot.line("l", {1}, {nan}), ArgumentError);
  EXPECT_THROW(plot.line("l", {0}, {1}), ArgumentError);
  EXPECT_THROW(plot.points("p", {1}, {1}, {0}), ArgumentError);
  EXPECT_THROW(plot.points("p", {1}, {1}, {0, 1}, {0, 1}), ArgumentError);
  EXPECT_THROW(Plot("t", {"x", false, std::pair{1.0, 1.0}}, {"y"}), ArgumentError);
  EXPECT_THROW(Plot("t", {"x", true, std::pair{0.0, 1.0}}, {"y"}), ArgumentError);
}

class PlotFile : public TemporaryFolder {};

TEST_F(PlotFile, HoldsEveryPanelOrIsNotWritten) {
  Plot plot("one", {"x"}, {"y"});
  plot.line("l", {1, 2}, {3, 4});
  write_svg(path("plot.svg"), {plot, plot, plot}, 2);
  EXPECT_EQ(count_of(read_text(path("plot.svg")), ">one</text>"), 3);
  EXPECT_THROW(write_svg(path("none.svg"), {}), ArgumentError);
  EXPECT_THROW(write_svg(path("none.svg"), {plot, Plot("empty", {"x"}, {"y"})}), ArgumentError);
  EXPECT_THROW(write_svg(path("nowhere/none.svg"), {plot}), FileError);
  EXPECT_FALSE(std::filesystem::exists(path("none.svg")));
}

}  // namespace
}  // namespace wheatstone::apps
