#include "capture/demosaic.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "capture/exposure_stack.h"
#include "core/exr.h"

namespace wheatstone::apps {

void add_demosaic(CLI::App& app) {
  auto* command = app.add_subcommand("demosaic", "All three colours at every photosite (DDFAPD)");
  struct Options {
    std::string input, pattern, out;
    bool no_refine = false;
  };
  auto o = std::make_shared<Options>();
  command->add_option("--input", o->input, "mosaic: one-channel EXR, or 16-bit PNG, TIFF or PGM")
      ->required();
  command->add_option("--pattern", o->pattern, "RGGB, BGGR, GRBG or GBRG")->required();
  command->add_flag("--no-refine", o->no_refine, "leave out the refining step");
  command->add_option("--out", o->out, "EXR: R, G, B, float, in the mosaic's unit, not clipped")
      ->required();
  command->footer(
      "Example:\n  wheatstone demosaic --input out/card/raw/view_000_exposure_0.png --pattern RGGB "
      "--out out/colour.exr");
  command->callback([=] {
    require_other_file(o->out, {o->input});
    require_exr_name(o->out);
    const LinearMosaic mosaic = read_linear_mosaic(o->input, bayer_pattern_from_string(o->pattern));
    cv::Mat3f band;
    write_exr_rows(o->out, {mosaic.values.size(), {{"R"}, {"G"}, {"B"}}},
                   [&](cv::Range rows, std::span<cv::Mat1f> bands) {
                     demosaic_rows(mosaic, rows, band, !o->no_refine);
                     cv::split(band, bands.data());
                   });
  });
}

}  // namespace wheatstone::apps
