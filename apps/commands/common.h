#pragma once
// What several subcommands share.

#include <CLI/App.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "core/dataset.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {

/// A line that rewrites itself on a terminal; one line when all is done otherwise.
void show_progress(const std::string& what, int done, int total);

struct SimulationOptions {
  std::string scene = "card";
  double scale = 0.25;
  std::uint64_t seed = 7;

  void add_to(CLI::App& command);
};

/// --chaos PROFILE: devices fail at random.
struct ChaosOption {
  std::string profile;  // empty: they do not

  /// `what` fails.
  void add_to(CLI::App& command, const std::string& what = "devices of the twin fail");
  double probability() const { return profile.empty() ? 0 : fault_probability(profile); }
  /// Others in every run, so that what resumes gets on. Throws ArgumentError for a rig that is not
  /// simulated (null) and for an unknown profile.
  void arm(SimulatedRig* twin) const;
};
/// Of faults at random, another one in every run.
std::uint64_t fresh_seed();

/// The dataset in a folder that must be one, of a version this program reads.
Dataset open_dataset(const std::string& folder);

/// Throws FileError where writing `out` would overwrite an input, or give a file of floats another
/// ending than .exr.
void require_other_file(const std::string& out, const std::vector<std::string>& inputs);
void require_exr_name(const std::string& out);

/// The twin that a captured folder came from; imported folders are shown on the default twin.
SimulatedRigOptions twin_of(const Dataset&, double scale);

}  // namespace wheatstone::apps
