#include "apps/commands/common.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include "core/error.h"

namespace wheatstone::apps {

void show_progress(const std::string& what, int done, int total) {
  if (isatty(STDERR_FILENO)) {
    fmt::print(stderr, "\r{}: {}/{}\x1b[K{}", what, done, total, done == total ? "\n" : "");
  } else if (done == total) {
    fmt::print(stderr, "{}: done\n", what);
  }
}

void SimulationOptions::add_to(CLI::App& command) {
  command.add_option("--scene", scene, "card, sphere or objects")->capture_default_str();
  command.add_option("--scale", scale, "of all pixel counts of the simulated rig, in (0, 1]")
      ->capture_default_str();
  command.add_option("--seed", seed, "of everything random")->capture_default_str();
}

void ChaosOption::add_to(CLI::App& command, const std::string& what) {
  command.add_option("--chaos", profile, what + " at random, for training: rare or often")
      ->check(CLI::IsMember({"rare", "often"}));
}

void ChaosOption::arm(SimulatedRig* twin) const {
  if (profile.empty()) return;
  if (!twin) throw ArgumentError("faults on cue need a simulated rig", "leave --chaos out");
  twin->world().faults.arm_at_random(probability(), fresh_seed());
}

std::uint64_t fresh_seed() {
  return static_cast<std::uint64_t>(SteadyClock().now_ns());
}

Dataset open_dataset(const std::string& folder) {
  const Dataset dataset(folder);
  if (!std::filesystem::exists(dataset.file("dataset.json")))
    throw FileError(
        dataset.file("dataset.json"), "is missing",
        std::filesystem::exists(dataset.file("session"))
            ? "the capture into this folder has not finished: run `wheatstone capture` again"
            : "name a folder that `wheatstone capture` or `wheatstone import` has finished");
  dataset.read_manifest();
  return dataset;
}

void require_other_file(const std::string& out, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    std::error_code error;  // one that is not there yet is another
    if (std::filesystem::equivalent(out, input, error))
      throw FileError(out, "is read from, and would be overwritten", "write to another file");
  }
}

void require_exr_name(const std::string& out) {
  if (std::filesystem::path(out).extension() != ".exr")
    throw FileError(out, "would hold an EXR under another name", "let the name end in .exr");
}

SimulatedRigOptions twin_of(const Dataset& dataset, double scale) {
  const DatasetManifest m = dataset.read_manifest();
  if (m.kind == "capture") return {m.scene, m.scale, m.seed};
  return {"card", scale, 7};
}

}  // namespace wheatstone::apps
