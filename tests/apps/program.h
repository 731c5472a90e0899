#pragma once
// The program as a person runs it, and folders to run it on.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/dataset.h"

namespace wheatstone::apps {

struct Outcome {
  int status = -1;  // exit status, or 128 + the signal that ended the program
  std::string out, err;
};

struct Surroundings {
  std::vector<std::string> environment;           // "NAME=value"
  std::optional<rlim_t> largest_file_bytes = {};  // writes beyond it fail as on a full disk
  std::function<bool()> kill_when = {};           // asked until it says true; then kill -9
  std::string input = {};                         // what is typed, a few lines at most
};

/// Turns this process, a child of the test, into the program.
[[noreturn]] void become_program(std::vector<std::string> arguments, const Surroundings& = {});

/// Runs the built program to its end.
Outcome run_program(const std::vector<std::string>& arguments, const Surroundings& = {});

/// Expects exit status 1 and all `parts` in one message on stderr.
void expect_refused(const Outcome&, const std::vector<std::string>& parts);

/// Expects that no temporary of an atomic write is left below the folder.
void expect_nothing_half_written(const std::filesystem::path& folder);

/// A fresh folder, removed at the end.
class TemporaryFolder : public ::testing::Test {
 protected:
  TemporaryFolder();
  ~TemporaryFolder() override;
  std::string path(const std::string& relative) const { return (root_ / relative).string(); }

  const std::filesystem::path root_;
};

/// A folder that can be rendered: three noisy 48x36 px views of the box, made without a capture
/// because that takes seconds, and eyes calibrated on the twin at scale 0.05.
Dataset write_small_light_field(const std::filesystem::path&);

}  // namespace wheatstone::apps
