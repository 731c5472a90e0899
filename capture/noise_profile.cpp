#include "capture/noise_profile.h"

#include <toml++/toml.h>
#include <limits>
#include <sstream>

#include "core/files.h"
#include "core/toml_file.h"

namespace wheatstone {
namespace {

constexpr const char* kSchema = "wheatstone-noise/1";
constexpr double kLargest = 1e12;

}  // namespace

NoiseProfile read_noise_profile(const std::filesystem::path& file) {
  const TomlTable t = TomlTable::read(file, "docs/hdr_merge.md");
  if (t.text("schema") != kSchema) t.fail("schema", std::string("is not \"") + kSchema + "\"");
  NoiseProfile out;
  out.camera = t.text_or("camera", "");
  out.source = t.text_or("source", "");
  out.bits = static_cast<int>(t.integer("bits", 1, 16));
  out.noise.dn_per_electron =
      t.numbers<3>("noise_k_rgb", std::numeric_limits<double>::min(), kLargest);
  out.noise.read_noise_e = t.number("std_read", 0, kLargest);
  out.noise.adc_noise = t.number("std_adc", 0, kLargest);
  t.finish();
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
