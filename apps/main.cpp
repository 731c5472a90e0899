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
    // CLI11 misses a subcommand before it says that a word is none.
    const std::vector<std::string> unknown = app.remaining(true);
    if (e.get_name() != "RequiredError" || unknown.empty() ||
        std::string(e.what()).find("subcommand") == std::string::npos)
      return app.exit(e);
    std::fputs(fmt::format("wheatstone: '{}' is no subcommand; see --help\n", unknown[0]).c_str(),
               stderr);
    return e.get_exit_code();
  } catch (const std::exception& e) {
    std::fputs(fmt::format("wheatstone: {}\n", e.what()).c_str(), stderr);  // which may be closed
    return 1;
  }
}
