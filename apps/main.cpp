#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "apps/commands/commands.h"
#include "core/error.h"
#include "core/memory.h"

int main(int argc, char** argv) {
  wheatstone::keep_freed_memory();
  CLI::App app("Wheatstone: an HDR multi-focal stereo display, from capture to the eye");
  app.set_version_flag("--version", WHEATSTONE_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  wheatstone demo --out out/demo");
  try {
    using namespace wheatstone::apps;
    for (const auto add :
         {add_demo, add_capture, add_merge, add_demosaic, add_estimate_exposures, add_measure_noise,
          add_calibrate, add_convert_camera, add_import, add_export_poses, add_render, add_present,
          add_report, add_metric, add_quality, add_doctor, add_jog, add_leds, add_emulate})
      add(app);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    return app.exit(e);
  } catch (const std::exception& e) {
    std::fputs(fmt::format("wheatstone: {}\n", e.what()).c_str(), stderr);  // which may be closed
    return 1;
  }
}
