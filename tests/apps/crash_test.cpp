// The program killed (SIGKILL) at 50 points of a capture, between any two changes of files, and run
// again: the dataset is the one that an undisturbed run writes, byte for byte.
#include <gmock/gmock.h>

#include <filesystem>
#include <map>

#include "core/files.h"
#include "core/random.h"
#include "program.h"
#include "tests/dataset_contents.h"
#include "traced_process.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kPoints = 50, kGroups = 5;

std::vector<std::string> capture(const fs::path& folder) {
  return {"capture", folder.string(), "--scale", "0.05", "--views",
          "2",       "--exposures",   "0.005",   "0.05"};
}

class CrashTest : public TemporaryFolder, public ::testing::WithParamInterface<int> {};

TEST_P(CrashTest, KilledCapturesEndAsOneThatWasNot) {
  const TracedEnd whole = run_traced(capture(root_ / "whole"), -1);
  ASSERT_EQ(whole.status, 0);
  ASSERT_GT(whole.calls, 100);
  const auto expected = dataset_contents(root_ / "whole");
  ASSERT_EQ(expected.size(), 7U + 5U);

  RandomStream random(11, static_cast<std::uint64_t>(GetParam()));
  for (int i = GetParam(); i < kPoints; i += kGroups) {
    const fs::path folder = root_ / std::to_string(i);
    // One point in each fiftieth of the way; every second run is killed again while it resumes.
    const int at = static_cast<int>((i + random.uniform()) * whole.calls / kPoints);
    const TracedEnd end = run_traced(capture(folder), at);
    ASSERT_TRUE(end.killed) << at;
    if (fs::exists(folder / "dataset.json")) {
      EXPECT_TRUE(dataset_contents(folder) == expected) << "not finished, but says so";
    }
    if (i % 2 == 1)
      run_traced(capture(folder), static_cast<int>(random.uniform() * whole.calls / 2));
    const Outcome resumed = run_program(capture(folder));
    ASSERT_EQ(resumed.status, 0) << resumed.err;
    EXPECT_TRUE(dataset_contents(folder) == expected)
        << "killed before call " << at << ", " << end.last_call;
  }
}

INSTANTIATE_TEST_SUITE_P(FiftyPoints, CrashTest, ::testing::Range(0, kGroups));

}  // namespace
}  // namespace wheatstone::apps
