#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/common.h"
#include "apps/commands/quality.h"
#include "rendering/motion_quality/alsarr/quality_polynomial.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone::apps {
namespace {

void fit_polynomials(const std::vector<std::string>& textures, const std::string& output) {
  std::vector<PolynomialTable::Material> materials;
  for (const std::string& texture : textures) {
    const Camojab camojab{CamojabTexture(read_grey_texture(texture))};
    PolynomialTable::Material material{std::filesystem::path(texture).stem().string(), {}};
    for (int mip = 0; mip < kMipRows; ++mip) {
      const auto samples = sample_quality_gains(camojab, mip);
      for (std::size_t rate = 0; rate < 2; ++rate)
        material.mips[static_cast<std::size_t>(mip)][rate] = fit_quality_polynomial(samples[rate]);
      show_progress(material.name, mip + 1, kMipRows);
    }
    materials.push_back(std::move(material));
  }
  PolynomialTable(std::move(materials)).write(output);
}

}  // namespace

void add_quality_polynomials(CLI::App& quality) {
  auto* command = quality.add_subcommand(
      "polynomials", "Fit the quality of textures, each one material, to CaMoJAB");
  auto textures = std::make_shared<std::vector<std::string>>();
  auto output = std::make_shared<std::string>();
  command->add_option("--texture", *textures, "EXR (Y or R, G, B) or 8- or 16-bit pictures")
      ->required();
  command->add_option("--output", *output, "CSV for `allocate` and `map`")->required();
  command->footer(
      "Example:\n  wheatstone quality polynomials --texture "
      "../shared/reference/perception/textures/"
      "grass.exr ../shared/reference/perception/textures/noise.exr --output out/polynomials.csv");
  command->callback([=] { fit_polynomials(*textures, *output); });
}

}  // namespace wheatstone::apps
