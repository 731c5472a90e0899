#include "hardware/argyll/spotread_output.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr double kWattsPerMilliwatt = 1e-3;
constexpr double kMostBands = 10'000;

/// Words, "texts in quotes" without the quotes; comments (#) left out.
std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
    } else if (c == '"') {
      const std::size_t end = std::min(text.find('"', at + 1), text.size());
      words.push_back(text.substr(at + 1, end - at - 1));
      at = end + 1;
    } else if (std::string_view(" \t\r\n").find(c) != std::string_view::npos) {
      ++at;
    } else {
      const std::size_t end = std::min(text.find_first_of(" \t\r\n\"#", at), text.size());
      words.push_back(text.substr(at, end - at));
      at = end;
    }
  }
  return words;
}

std::optional<double> number_of(std::string_view word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

std::optional<Eigen::Vector3d> parse_spotread_xyz(const std::string& output) {
  constexpr std::string_view kLabel = "Result is XYZ:";
  const std::size_t at = output.rfind(kLabel);
  if (at == std::string::npos) return std::nullopt;
  std::string_view line = std::string_view(output).substr(at + kLabel.size());
  line = line.substr(0, line.find_first_of(",\n"));
  const std::vector<std::string_view> words = words_of(line);
  if (words.size() != 3) return std::nullopt;
  Eigen::Vector3d xyz;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> value = number_of(words[static_cast<std::size_t>(i)]);
    if (!value) return std::nullopt;
    xyz[i] = *value;
  }
  return xyz;
}

SpectralRadiance parse_cgats_spectrum(const std::string& what, const std::string& text) {
  const auto refuse = [&](const std::string& problem) {
    throw DeviceError(Kind::kProtocol, fmt::format("{} writes a spectrum {}", what, problem),
                      "check its version, and measure again");
  };
  const std::vector<std::string_view> words = words_of(text);
  if (words.empty() || words[0] != "SPECT") refuse("that is no CGATS file of type SPECT");
  const auto after = [&](std::string_view key) {
    // KEYWORD "SPECTRAL_BANDS" only announces the key.
    for (std::size_t i = 0; i + 1 < words.size(); ++i)
      if (words[i] == key && (i == 0 || words[i - 1] != "KEYWORD"))
        if (const std::optional<double> value = number_of(words[i + 1])) return *value;
    refuse(fmt::format("without {}", key));
    return 0.0;
  };
  const double bands = after("SPECTRAL_BANDS"), first = after("SPECTRAL_START_NM"),
               last = after("SPECTRAL_END_NM"), norm = after("SPECTRAL_NORM");
  if (!(bands >= 2 && bands <= kMostBands && bands == std::floor(bands) && last > first &&
        norm > 0))
    refuse(fmt::format("of {} bands from {} to {} nm, norm {}", bands, first, last, norm));
  if (after("NUMBER_OF_SETS") != 1) refuse("of more than one reading");
  SpectralRadiance spectrum{first, (last - first) / (bands - 1), {}};
  std::size_t i = 0;
  while (i < words.size() && words[i] != "BEGIN_DATA") ++i;
  for (++i; i < words.size() && words[i] != "END_DATA"; ++i) {
    const std::optional<double> value = number_of(words[i]);
    if (!value) refuse("with what is no number: " + printable(std::string(words[i].substr(0, 40))));
    spectrum.values.push_back(*value * kWattsPerMilliwatt / norm);
    if (!std::isfinite(spectrum.values.back())) refuse("with values out of range");
  }
  if (i >= words.size()) refuse("without its end");
  if (static_cast<double>(spectrum.values.size()) != bands)
    refuse(fmt::format("with {} values for {} bands", spectrum.values.size(), bands));
  return spectrum;
}

}  // namespace wheatstone
