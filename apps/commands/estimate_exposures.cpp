#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "capture/exposure_stack.h"
#include "capture/exposure_times.h"
#include "core/error.h"

namespace wheatstone::apps {
namespace {

ExposureTimes estimate(const std::string& frames_json, const ExposureStack& stack,
                       ExposurePairing pairing, bool weighted) {
  try {
    return estimate_exposure_times(stack.exposures, stack.merging, pairing, weighted);
  } catch (const ArgumentError& e) {
    throw FileError(frames_json, e.what(), "");
  }
}

}  // namespace

void add_estimate_exposures(CLI::App& app) {
  auto* command =
      app.add_subcommand("estimate-exposures", "The exposure times a stack was really taken with");
  struct Options {
    std::string frames, method;
    bool weighted = false, as_json = false;
  };
  auto o = std::make_shared<Options>();
  command->add_option("--frames", o->frames, "stack (docs/hdr_merge.md)")->required();
  command->add_option("--method", o->method, "pairwise or mst")->required();
  command->add_flag("--weighted", o->weighted, "weigh each pixel by its noise");
  command->add_flag("--json", o->as_json, "the result as JSON on standard output");
  command->footer(
      "Example:\n  wheatstone estimate-exposures --frames frames.json --method mst --weighted");
  command->callback([=] {
    const ExposurePairing pairing = exposure_pairing_from_string(o->method);
    const ExposureStack stack = read_exposure_stack(o->frames);
    const ExposureTimes times = estimate(o->frames, stack, pairing, o->weighted);
    std::vector<double> nominal_s;
    for (const RawExposure& e : stack.exposures) nominal_s.push_back(e.exposure.value());
    if (o->as_json) {
      const nlohmann::json out = {{"method", o->method},
                                  {"weighted", o->weighted},
                                  {"exposure_s", times.exposure_s},
                                  {"nominal_exposure_s", nominal_s},
                                  {"estimated", times.estimated},
                                  {"equations", times.equations},
                                  {"note", times.note}};
      fmt::print("{}\n", out.dump(2));
      return;
    }
    for (std::size_t i = 0; i < nominal_s.size(); ++i)
      fmt::print("{}: {:.6g} s, nominal {:.6g} s{}\n", stack.files[i].string(), times.exposure_s[i],
                 nominal_s[i], times.estimated[i] ? "" : " (kept)");
    if (!times.note.empty()) fmt::print(stderr, "{}\n", times.note);
  });
}

}  // namespace wheatstone::apps
