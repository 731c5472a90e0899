#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "rendering/gl/offscreen.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {

void add_doctor(CLI::App& app) {
  auto* command = app.add_subcommand("doctor", "What works on this machine, and what to do if not");
  command->footer("Example:\n  wheatstone doctor");
  command->callback([] {
    const OffscreenContext context;
    fmt::print("OpenGL: {} on {}\n", context.version(), context.renderer());
    SimulatedRig twin({"card", 0.02, 1});
    const Rig rig = twin.rig();
    const Length reached = rig.stage->home(rig.clock.in(60.0_s));
    fmt::print("simulated rig: rail homed at {:.3f} mm, {} markers, camera {}\n", reached.value(),
               rig.markers->count(), rig.camera_profile.serial);
  });
}

}  // namespace wheatstone::apps
