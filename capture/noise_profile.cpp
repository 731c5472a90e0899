#include "capture/noise_profile.h"

#include <toml++/toml.h>
#include <cmath>
#include <sstream>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

constexpr const char* kSchema = "wheatstone-noise/1";
constexpr const char* kRemedy = "see docs/hdr_merge.md for this file";

double number(const toml::node_view<const toml::node>& node, const std::filesystem::path& file,
              const std::string& key, bool may_be_zero) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value) || *value < 0 || (*value == 0 && !may_be_zero))
    throw FileError(
        file, "key \"" + key + "\" must be a number " + (may_be_zero ? "of at least 0" : "above 0"),
        kRemedy);
  return *value;
}

}  // namespace

NoiseProfile read_noise_profile(const std::filesystem::path& file) {
  toml::table table;
  try {
    table = toml::parse(read_text(file, std::size_t{1} << 20), file.string());
  } catch (const toml::parse_error& e) {
    std::ostringstream problem;
    problem << "is not valid TOML: line " << e.source().begin.line << ": " << e.description();
    throw FileError(file, problem.str(), kRemedy);
  }
  const toml::table& t = table;
  if (t["schema"].value_or(std::string()) != kSchema)
    throw FileError(file, std::string("has no schema \"") + kSchema + "\"", kRemedy);
  for (const auto& [key, value] : t) {
    bool known = false;
    for (const char* k :
         {"schema", "camera", "bits", "noise_k_rgb", "std_read", "std_adc", "source"})
      known = known || key.str() == k;
    if (!known)
      throw FileError(file, "key \"" + std::string(key.str()) + "\" is not a key of this file",
                      kRemedy);
  }
  NoiseProfile out;
  out.camera = t["camera"].value_or(std::string());
  out.source = t["source"].value_or(std::string());
  const auto bits = t["bits"].value<int>();
  if (!bits || *bits < 1 || *bits > 16)
    throw FileError(file, "key \"bits\" must be a whole number from 1 to 16", kRemedy);
  out.bits = *bits;
  const toml::array* k = t["noise_k_rgb"].as_array();
  if (k == nullptr || k->size() != 3)
    throw FileError(file, "key \"noise_k_rgb\" must be a list of 3 numbers", kRemedy);
  for (std::size_t i = 0; i < 3; ++i)
    out.noise.dn_per_electron[i] = number(t["noise_k_rgb"][i], file, "noise_k_rgb", false);
  out.noise.read_noise_e = number(t["std_read"], file, "std_read", true);
  out.noise.adc_noise = number(t["std_adc"], file, "std_adc", true);
  return out;
}

void write_noise_profile(const std::filesystem::path& file, const NoiseProfile& profile) {
  const SensorNoise& n = profile.noise;
  const toml::table table{{"schema", kSchema},
                          {"camera", profile.camera},
                          {"bits", profile.bits},
                          {"noise_k_rgb", toml::array{n.dn_per_electron[0], n.dn_per_electron[1],
                                                      n.dn_per_electron[2]}},
                          {"std_read", n.read_noise_e},
                          {"std_adc", n.adc_noise},
                          {"source", profile.source}};
  std::ostringstream text;
  text << table << "\n";
  write_text_atomically(file, text.str());
}

}  // namespace wheatstone
