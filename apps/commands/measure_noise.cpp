#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "calib/photon_transfer.h"
#include "capture/exposure_stack.h"
#include "capture/noise_profile.h"
#include "core/error.h"
#include "core/json.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

// chi2 per measurement of a noise model that is doubtful, and of one that is none.
constexpr double kDoubtfulChi2 = 3, kUselessChi2 = 100;

void measure_noise(const std::filesystem::path& file, const std::string& out) {
  const nlohmann::json document = read_json(file);
  const StrictObject top(document, file, "",
                         {"camera", "pattern", "bits", "black", "saturation", "pairs"});
  NoiseProfile profile;
  profile.camera = top.text("camera");
  const CodeRange range = code_range_from(top);
  profile.bits = range.bits;
  const nlohmann::json& list = top.get("pairs");
  if (!list.is_array() || list.empty()) top.fail("pairs", "must be a list of pairs");
  std::vector<FlatPair> pairs;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const StrictObject pair(list[i], file, "pairs[" + std::to_string(i) + "].", {"a", "b", "gain"});
    const auto read = [&](const char* key) {
      return read_frame(file.parent_path() / pair.text(key), range);
    };
    pairs.push_back({read("a"), read("b"), pair.positive("gain")});
  }
  PhotonTransfer measured;
  try {
    measured = measure_sensor_noise(pairs, range.black_dn, range.saturation_dn);
  } catch (const ArgumentError& e) {
    throw FileError(file, e.what(), "");
  }
  const std::string misfit =
      fmt::format("the noise model misses the pairs: chi2 per measurement is {:.3g}, not about 1",
                  measured.chi2_per_measurement);
  const std::string remedy =
      "check black and gain, and that both frames of each pair show the same light";
  if (!(measured.chi2_per_measurement <= kUselessChi2)) throw FileError(file, misfit, remedy);
  if (measured.chi2_per_measurement > kDoubtfulChi2)
    fmt::print(stderr, "warning: {}; {}\n", misfit, remedy);
  profile.noise = measured.noise;
  profile.source = fmt::format("photon transfer, {} of flat fields", counted(pairs.size(), "pair"));
  write_noise_profile(out, profile);
  const SensorNoise &n = measured.noise, &s = measured.sigma;
  for (std::size_t c = 0; c < 3; ++c)
    fmt::print("k {}: {:.6g} +- {:.2g} DN per electron\n", "RGB"[c], n.dn_per_electron[c],
               s.dn_per_electron[c]);
  if (measured.separated)
    fmt::print("std_read: {:.4g} +- {:.2g} electrons\n", n.read_noise_e, s.read_noise_e);
  else
    fmt::print("std_read: unknown, all pairs have one gain; std_adc holds it for that gain only\n");
  fmt::print("std_adc: {:.4g} +- {:.2g}\nchi2 per measurement: {:.3g}\n", n.adc_noise, s.adc_noise,
             measured.chi2_per_measurement);
}

}  // namespace

void add_measure_noise(CLI::App& app) {
  auto* command =
      app.add_subcommand("measure-noise", "A camera's noise profile from pairs of flat fields");
  auto flats = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command->add_option("--flats", *flats, "list of pairs (docs/hdr_merge.md)")->required();
  command->add_option("--out", *out, "noise profile, TOML")->required();
  command->footer("Example:\n  wheatstone measure-noise --flats flats.json --out camera.toml");
  command->callback([=] {
    require_other_file(*out, {*flats});
    measure_noise(*flats, *out);
  });
}

}  // namespace wheatstone::apps
