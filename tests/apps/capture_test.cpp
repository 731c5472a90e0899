// `wheatstone capture` as an operator or a program uses it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/dataset.h"
#include "core/journal.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class CaptureTest : public TemporaryFolder {
 protected:
  std::vector<std::string> capture(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"capture", path("d"),     "--scale", "0.05", "--views",
                                          "2",       "--exposures", "0.005",   "0.05"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

std::vector<json> lines_of(const std::string& text) {
  std::vector<json> out;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) out.push_back(json::parse(line));
  return out;
}

TEST_F(CaptureTest, ADryRunForetellsAndTouchesNothing) {
  const Outcome outcome = run_program(capture({"--dry-run", "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(path("d")));
  const std::vector<json> lines = lines_of(outcome.out);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].at("event"), "forecast");
  EXPECT_EQ(lines[0].at("frames"), 7);
  EXPECT_EQ(lines[0].at("bytes"), 7 * 368 * 246 * 2);
  EXPECT_GT(lines[0].at("duration_s"), 5);
  EXPECT_THAT(run_program(capture({"--dry-run"})).out, HasSubstr("7 of 7 frames"));
}

TEST_F(CaptureTest, EventsAreTheJournalWithProgress) {
  const Outcome outcome = run_program(capture({"--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  std::vector<json> records;
  int done = 0;
  for (const json& line : lines_of(outcome.out)) {
    if (line.at("event") == "progress") {
      EXPECT_GE(line.at("done"), done);
      done = line.at("done");
      EXPECT_EQ(line.at("total"), 7);
      EXPECT_GE(line.at("seconds_left"), 0);
    } else if (line.at("event") != "forecast") {
      records.push_back(line);
    }
  }
  EXPECT_EQ(done, 7);
  EXPECT_EQ(records, Journal::read(path("d/session/journal.jsonl")));
}

TEST_F(CaptureTest, PlannedExposuresAreKeptWhenItGoesOn) {
  const std::vector<std::string> planned = {"capture",    path("d"), "--scale",           "0.05",
                                            "--views",    "2",       "--signal-to-noise", "40",
                                            "--coverage", "0.5"};
  ASSERT_EQ(run_program(planned).status, 0);
  const Dataset dataset(path("d"));
  const std::size_t exposures = dataset.read_frames().at(0).exposures.size();
  EXPECT_GE(exposures, 1U);
  const std::string proof = run_program({"merge", path("d")}).out;
  EXPECT_THAT(proof, HasSubstr("of each of 2 views; 50.0 % were asked for"));
  EXPECT_THAT(proof, ::testing::Not(HasSubstr("MISSED")));
  fs::remove(dataset.file(dataset.read_frames().at(1).exposures.at(0).file));
  const Outcome again = run_program(planned);
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("is missing: taken again"));
  std::vector<std::string> other = planned;
  other[7] = "60";
  const Outcome refused = run_program(other);
  expect_refused(refused, {"plan/signal_to_noise: 40.0 there, 60.0 asked for"});
  EXPECT_EQ(refused.out, "") << "a forecast of what will not be";
  other.emplace_back("--dry-run");
  expect_refused(run_program(other), {"plan/signal_to_noise: 40.0 there, 60.0 asked for"});
  other.pop_back();
  other[7] = "4000";
  other[1] = path("e");
  expect_refused(run_program(other), {"more than this camera"});
  EXPECT_FALSE(fs::exists(path("e")));
}

/// Sends the signal when the program says that it has taken its first frame.
int interrupted(std::vector<std::string> arguments, int signal) {
  arguments.emplace_back("--json");
  std::array<int, 2> out{};
  if (::pipe(out.data()) != 0) throw std::runtime_error("no pipe");
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(out[1], STDOUT_FILENO);
    ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
    become_program(arguments);
  }
  ::close(out[1]);
  std::string said;
  bool sent = false;
  for (char c = 0; ::read(out[0], &c, 1) == 1;) {
    said += c;
    if (!sent && said.find("\"event\":\"frame\"") != std::string::npos)
      sent = ::kill(child, signal) == 0;
  }
  ::close(out[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST_F(CaptureTest, CtrlCStopsAtASafePlaceAndTheSameCommandGoesOn) {
  for (const int signal : {SIGINT, SIGTERM}) {
    fs::remove_all(path("d"));
    EXPECT_EQ(interrupted(capture(), signal), 1);
    EXPECT_FALSE(fs::exists(path("d/dataset.json")));
    const std::vector<json> records = Journal::read(path("d/session/journal.jsonl"));
    EXPECT_EQ(records.back().at("event"), "stopped");
    EXPECT_THAT(records.back().at("why").get<std::string>(), HasSubstr("to resume"));
    EXPECT_EQ(run_program(capture()).status, 0);
    EXPECT_EQ(Dataset(path("d")).read_frames().size(), 2U);
  }
}

TEST_F(CaptureTest, TimesAreTakenAsTheCameraShowsThem) {
  const Outcome outcome = run_program({"capture", path("d"), "--scale", "0.05", "--exposures",
                                       "1/200", "0.05", "--dry-run", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(lines_of(outcome.out)[0].at("plan").at("exposures_s"), json({1 / 200.0, 0.05}));
}

TEST_F(CaptureTest, MarkersThatAreTooSmallAreToldOfAtOnce) {
  const Outcome small = run_program(capture({"--json"}));
  ASSERT_EQ(small.status, 0) << small.err;
  const std::vector<json> lines = lines_of(small.out);
  const auto event = std::find_if(lines.begin(), lines.end(),
                                  [](const json& l) { return l.at("event") == "markers"; });
  ASSERT_NE(event, lines.end());
  EXPECT_THAT(event->at("problem").get<std::string>(), HasSubstr("of 4 marker LEDs"));
  EXPECT_EQ(event->at("file"), "raw/view_000_markers.png");
  fs::remove_all(path("d"));
  EXPECT_THAT(run_program(capture()).err, HasSubstr("no view gets a pose"));
  const Outcome large = run_program({"capture", path("e"), "--scale", "0.1", "--views", "1"});
  EXPECT_EQ(large.status, 0);
  EXPECT_THAT(large.err, ::testing::Not(HasSubstr("warning")));
}

TEST_F(CaptureTest, RefusesPlansThatCannotBe) {
  expect_refused(run_program({"capture", path("d"), "--views", "0"}), {"at least one view"});
  expect_refused(run_program({"capture", path("d"), "--exposures", "0.1", "0.1"}), {"twice"});
  expect_refused(run_program({"capture", path("d"), "--settle", "-1"}), {"rest"});
  for (const char* bad : {"1/0", "x", "-0.1", "1/60s", "/60"})
    expect_refused(run_program({"capture", path("d"), "--exposures", bad}),
                   {"'" + std::string(bad) + "' is no exposure time", "1/60"});
  for (const char* dry : {"--dry-run", "--json"})
    expect_refused(run_program({"capture", path("d"), "--exposures", "1/60", "60", dry}),
                   {"cannot expose for 60 s"});
  EXPECT_NE(run_program({"capture", path("d"), "--signal-to-noise", "0"}).status, 0);
  EXPECT_FALSE(fs::exists(path("d")));
}

}  // namespace
}  // namespace wheatstone::apps
