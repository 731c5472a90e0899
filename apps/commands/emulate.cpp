#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stop_on_signal.h"
#include "core/clock.h"
#include "core/error.h"
#include "sim/wire/arduino_gantry_firmware.h"
#include "sim/wire/grbl_firmware.h"
#include "sim/wire/jeti_firmware.h"
#include "sim/wire/line_faults.h"
#include "sim/wire/pty_peer.h"

namespace wheatstone::apps {
namespace {

constexpr Nanoseconds kLookEveryNs = 50'000'000;

/// Sees the box at a twentieth of its pixels, lit by half of its LEDs.
class JetiBeforeTheBox final : public SerialFirmware {
 public:
  JetiBeforeTheBox() { world_.light.led_drive = 0.5; }
  void receive(std::string_view bytes, Nanoseconds now) override { firmware_.receive(bytes, now); }
  std::string run(Nanoseconds now) override { return firmware_.run(now); }
  Nanoseconds next_event() const override { return firmware_.next_event(); }

 private:
  World world_{"card", 0.05, 7};
  JetiFirmware firmware_{world_};
};

std::unique_ptr<SerialFirmware> firmware_of(const std::string& name) {
  if (name == "grbl") return std::make_unique<GrblFirmware>();
  if (name == "arduino-gantry") return std::make_unique<ArduinoGantryFirmware>();
  if (name == "jeti") return std::make_unique<JetiBeforeTheBox>();
  throw ArgumentError("there is no emulated device " + name, "use grbl, arduino-gantry or jeti");
}

void emulate(const std::string& name, const std::string& link, double speed,
             const ChaosOption& chaos) {
  const std::unique_ptr<SerialFirmware> firmware = firmware_of(name);
  const StopOnSignal stop;
  PtyPeer peer(*firmware, link, speed);
  const auto say = [](const std::string& line) {
    fmt::print("{}\n", line);
    std::fflush(stdout);
  };
  say(fmt::format("{} on {}; Ctrl-C ends it", name, peer.path().string()));
  SteadyClock clock;
  LineFaults faults(peer, chaos.probability(), fresh_seed());
  while (!stop.token().stop_requested()) {
    for (const std::string& fault : faults.tend(clock.now_ns())) say(fault);
    clock.wait_until(clock.now_ns() + kLookEveryNs);
  }
}

}  // namespace

void add_emulate(CLI::App& app) {
  auto* command = app.add_subcommand(
      "emulate", "A device of the rig at the other end of a pseudo-terminal, for any client");
  auto name = std::make_shared<std::string>();
  auto link = std::make_shared<std::string>();
  auto speed = std::make_shared<double>(1);
  command->add_option("device", *name, "grbl, arduino-gantry or jeti")->required();
  command->add_option("--link", *link, "symbolic link to the terminal, removed at the end");
  command->add_option("--speed", *speed, "how many times as fast as the real device")
      ->capture_default_str();
  auto chaos = std::make_shared<ChaosOption>();
  chaos->add_to(*command, "the line fails");
  command->footer("Example:\n  wheatstone emulate grbl --link out/grbl");
  command->callback([=] { emulate(*name, *link, *speed, *chaos); });
}

}  // namespace wheatstone::apps
