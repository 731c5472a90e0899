#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/commands/commands.h"
#include "core/error.h"

int main(int argc, char** argv) {
  CLI::App app("Wheatstone: an HDR multi-focal stereo display, from capture to the eye");
  app.set_version_flag("--version", WHEATSTONE_VERSION);
  app.require_subcommand(1);
  app.footer("Example:\n  wheatstone demo --out out/demo");
  try {
    using namespace wheatstone::apps;
    for (const auto add :
         {add_demo, add_capture, add_merge, add_calibrate, add_import, add_render, add_present,
          add_metric, add_quality, add_doctor, add_convert_camera, add_export_poses})
      add(app);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& e) {
    return app.exit(e);
  } catch (const std::exception& e) {
    fmt::print(stderr, "wheatstone: {}\n", e.what());
    return 1;
  }
}
