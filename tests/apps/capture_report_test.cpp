#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "apps/capture_figures.h"
#include "apps/capture_statistics.h"
#include "apps/capture_verdict.h"
#include "core/files.h"
#include "core/png.h"
#include "core/random.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CaptureReport : public TemporaryFolder {
 protected:
  std::string page() { return read_text(path("d/report.html"), std::size_t{64} << 20); }
};

TEST_F(CaptureReport, SaysWhatThereIsAndWhatIsNotYet) {
  ASSERT_EQ(run_program({"capture", path("d"), "--scale", "0.1", "--views", "3"}).status, 0);
  const Outcome early = run_program({"report", path("d")});
  ASSERT_EQ(early.status, 0) << early.err;
  EXPECT_THAT(early.out, HasSubstr("report.html"));
  EXPECT_THAT(page(), AllOf(HasSubstr("Not merged yet"), HasSubstr("Not calibrated yet"),
                            HasSubstr("<td>1/240 s</td>"), HasSubstr("Nothing disturbed it"),
                            HasSubstr("What each exposure measures"),
                            HasSubstr("Nothing is wrong with what has been made so far")));
  EXPECT_LT(page().find("Verdict"), page().find("What to do"));
  EXPECT_LT(page().find("What to do"), page().find("The session"));
  EXPECT_THAT(page(), AllOf(HasSubstr("<code>wheatstone merge " + path("d") + "</code>"),
                            HasSubstr("<code>wheatstone calibrate poses " + path("d"))));

  ASSERT_EQ(run_program({"merge", path("d")}).status, 0);
  ASSERT_EQ(run_program({"calibrate", "poses", path("d")}).status, 0);
  ASSERT_EQ(run_program({"report", path("d"), "--out", path("elsewhere.html")}).status, 0);
  ASSERT_EQ(run_program({"report", path("d")}).status, 0);
  EXPECT_THAT(page(), AllOf(Not(HasSubstr("not merged yet")), Not(HasSubstr("Not calibrated yet")),
                            HasSubstr("3 of 3 views are merged"), HasSubstr("view_002 at 16"),
                            HasSubstr("px RMS over all views"), HasSubstr("Straightness"),
                            HasSubstr("in percent of its light"), HasSubstr("cd/m²"),
                            Not(HasSubstr("cd/m^2")), Not(HasSubstr("wheatstone merge")),
                            HasSubstr("<code>wheatstone calibrate eyes " + path("d"))));
  EXPECT_EQ(read_text(path("elsewhere.html"), std::size_t{64} << 20), page()) << "the same again";
  EXPECT_THAT(page(), Not(HasSubstr("http-equiv")));

  // The same views cropped one by one take less memory and render as well.
  const Outcome own = run_program({"calibrate", "poses", path("d"), "--crop", "per-view"});
  ASSERT_EQ(own.status, 0) << own.err;
  EXPECT_THAT(own.out, AllOf(HasSubstr("views cropped from"), HasSubstr("one size for all")));
  ASSERT_EQ(run_program({"calibrate", "eyes", path("d")}).status, 0);
  const Outcome rendered = run_program({"render", path("d"), "--method", "drlf"});
  EXPECT_EQ(rendered.status, 0) << rendered.err;
}

/// The first picture of the page.
cv::Mat3b first_picture(const std::string& page) {
  const std::string head = "data:image/png;base64,";
  const std::size_t begin = page.find(head);
  if (begin == std::string::npos) return {};
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> png;
  unsigned bits = 0;
  int count = 0;
  for (std::size_t i = begin + head.size(); digits.find(page[i]) != std::string::npos; ++i) {
    bits = bits << 6 | static_cast<unsigned>(digits.find(page[i]));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    png.push_back(static_cast<unsigned char>(bits >> count));
  }
  return cv::imdecode(png, cv::IMREAD_COLOR);
}

TEST_F(CaptureReport, BeginsWithWhatIsWrong) {
  // Exposed so long that nearly all of it saturates.
  ASSERT_EQ(run_program(
                {"capture", path("d"), "--scale", "0.05", "--views", "2", "--exposures", "8", "30"})
                .status,
            0);
  const Outcome merged = run_program({"merge", path("d")});
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_THAT(merged.err, AllOf(HasSubstr("warning: "), HasSubstr("saturated")));
  ASSERT_EQ(run_program({"report", path("d")}).status, 0);
  const std::string verdict = page().substr(0, page().find("The session"));
  EXPECT_THAT(verdict, AllOf(HasSubstr("are saturated in the shortest exposure"),
                             HasSubstr("Capture with a shorter exposure"),
                             Not(HasSubstr("Nothing is wrong"))));
  const cv::Mat3b picture = first_picture(page());
  ASSERT_FALSE(picture.empty());
  const MergedTrust trust = merged_trust(path("d/hdr/view_000.exr"));
  int cyan = 0;
  for (const cv::Vec3b& bgr : picture) cyan += bgr == cv::Vec3b(255, 255, 0);
  EXPECT_GT(cv::countNonZero(trust.saturated), 0.3 * static_cast<double>(trust.saturated.total()));
  EXPECT_NEAR(static_cast<double>(cyan) / static_cast<double>(picture.total()),
              cv::countNonZero(trust.saturated) / static_cast<double>(trust.saturated.total()),
              0.15);

  // Too dark, in part not merged, and one merged file damaged.
  ASSERT_EQ(run_program({"capture", path("e"), "--scale", "0.05", "--views", "3", "--exposures",
                         "0.000125"})
                .status,
            0);
  ASSERT_EQ(run_program({"merge", path("e")}).status, 0);
  std::filesystem::remove(path("e/hdr/view_000.exr"));
  std::filesystem::resize_file(path("e/hdr/view_001.exr"), 3000);
  const std::vector<CapturedView> views = Dataset(path("e")).read_frames();
  std::vector<ViewStatistics> statistics;
  for (const CapturedView& v : views)
    statistics.push_back(view_statistics(Dataset(path("e")), v, Dataset(path("e")).read_camera()));
  std::vector<std::string> problems;
  for (const CaptureProblem& p : capture_problems(Dataset(path("e")), views, statistics))
    problems.push_back(p.what + "|" + p.remedy + "|" + p.command);
  EXPECT_THAT(
      problems,
      testing::IsSupersetOf(
          {testing::Matcher<std::string>(HasSubstr("in the noise of the longest")),
           testing::Matcher<std::string>(
               AllOf(HasSubstr("view_000: not merged"), HasSubstr("|wheatstone merge "))),
           testing::Matcher<std::string>(HasSubstr("view_001: the HDR file is not what"))}));
}

TEST_F(CaptureReport, ManyExposuresMakeALongerTableNotAWiderOne) {
  std::vector<std::string> capture = {"capture", path("d"), "--scale",    "0.05",
                                      "--views", "2",       "--exposures"};
  for (int i = 0; i < 12; ++i) capture.push_back(std::to_string(0.001 * (i + 1)));
  ASSERT_EQ(run_program(capture).status, 0);
  ASSERT_EQ(run_program({"report", path("d")}).status, 0);
  const std::string html = page(), table = html.substr(html.find("Raw codes and clipping"));
  const std::string header = table.substr(0, table.find("</tr>"));
  EXPECT_EQ(header.find("1/1000 s"), std::string::npos);
  for (const char* row : {"<td>1/1000 s</td>", "<td>1/83.33 s</td>"})
    EXPECT_THAT(table, HasSubstr(row));
}

TEST_F(CaptureReport, RefusesWhatIsNoCaptureOrDamaged) {
  expect_refused(run_program({"report", path("none")}), {"dataset.json", "capture"});
  const Dataset field = write_small_light_field(root_ / "field");
  DatasetManifest manifest = field.read_manifest();
  manifest.kind = "light-field";
  field.write_manifest(manifest);
  expect_refused(run_program({"report", path("field")}), {"is no capture"});
  ASSERT_EQ(run_program({"capture", path("d"), "--scale", "0.05", "--views", "1"}).status, 0);
  write_text_atomically(path("d/raw/view_000_exposure_1.png"), "x");
  expect_refused(run_program({"report", path("d")}), {"view_000_exposure_1.png"});
  EXPECT_FALSE(std::filesystem::exists(path("d/report.html")));
  expect_nothing_half_written(root_);
}

TEST_F(CaptureReport, MeasuresNoiseAndClippingOfFramesThatAreKnown) {
  CameraProfile camera;
  camera.black_dn = 500;
  camera.white_dn = 16000;
  camera.dn_per_electron = {0.5, 0.5, 0.5};
  camera.read_noise_e = 2;
  camera.adc_noise = 3;
  CapturedView view{"v", 0, 0, {{"short.png", 0.01}, {"long.png", 0.04}}, {}};
  for (const double factor : {1.0, 1.5}) {
    RandomStream random(1, 2);
    for (const ExposureRecord& e : view.exposures) {
      MosaicImage frame{cv::Mat1w(200, 300), camera.pattern};
      for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 300; ++x) {
          const double signal = 1000.0 * (x + 1) * e.exposure_s;  // DN
          const double sigma = std::sqrt(signal * 0.5 + 13 * 0.25);
          frame.dn(y, x) = static_cast<std::uint16_t>(
              std::clamp(500 + signal + factor * sigma * random.normal(), 0.0, 16000.0));
        }
      frame.dn(cv::Rect(0, 0, 300, 20)) = 16000;
      write_mosaic_png(root_ / e.file, frame);
    }
    const ViewStatistics s = view_statistics(Dataset(root_), view, camera);
    ASSERT_EQ(s.frames.size(), 2U);
    EXPECT_NEAR(s.frames[0].saturated, 0.1, 1e-9);
    double sum = 0;
    for (const double share : s.frames[1].histogram) sum += share;
    EXPECT_NEAR(sum, 1, 1e-9);
    ASSERT_GT(s.noise.size(), 5U);
    double squares = 0;
    int levels = 0;
    for (const NoiseLevel& level : s.noise)
      if (level.signal_dn > 100) {
        EXPECT_NEAR(level.measured_over_model, factor, 0.12 * factor) << level.signal_dn;
        const double off = (level.measured_over_model - factor) / level.sigma;
        EXPECT_LT(std::abs(off), 4) << level.signal_dn;
        squares += off * off;
        ++levels;
      }
    ASSERT_GE(levels, 5);
    EXPECT_THAT(std::sqrt(squares / levels), AllOf(testing::Gt(0.4), testing::Lt(1.7)));
    const std::string plot = noise_figure(s).svg(460, 340);
    std::size_t bars = 0;
    for (auto at = plot.find("class=\"bar\""); at != std::string::npos;
         at = plot.find("class=\"bar\"", at + 1))
      ++bars;
    EXPECT_EQ(bars, s.noise.size());
  }
  EXPECT_NEAR(least_signal_dn(camera), 2 * std::sqrt(least_signal_dn(camera) * 0.5 + 13 * 0.25),
              1e-9);
}

}  // namespace
}  // namespace wheatstone::apps
