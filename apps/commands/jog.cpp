#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/drivers.h"
#include "apps/rig_source.h"
#include "apps/stop_on_signal.h"
#include "core/error.h"
#include "core/files.h"
#include "core/png.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

constexpr const char* kHelp =
    "  home              find the rail's reference end\n"
    "  stage MM          move the camera\n"
    "  home platform     find the platform's reference\n"
    "  platform DEG      turn the box\n"
    "  where             positions and lights as the devices say\n"
    "  markers 0 2 ...   light these marker LEDs; all; none\n"
    "  leds DRIVE        ceiling, 0 to 1\n"
    "  shoot S FILE.png  one raw frame of S seconds\n"
    "  measure           luminance and colour that the spectroradiometer sees\n"
    "  measure FILE.csv  and its spectrum\n"
    "  aim on, aim off   its aiming light\n"
    "  off               everything dark and standing\n"
    "  help, quit\n";

double number(std::istringstream& words, const char* what) {
  std::string word;
  words >> word;
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw ArgumentError(std::string("no ") + what + " is given", "say help for the commands");
  return value;
}

class Console {
 public:
  Console(const Rig& rig, const RigDescription& description, const StopOnSignal& stop)
      : rig_(rig), description_(description), stop_(stop) {}

  /// False: it is over.
  bool obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb;
    if (!(words >> verb)) return true;
    if (verb == "quit") return false;
    if (verb == "help")
      fmt::print("{}", kHelp);
    else if (verb == "home")
      home(words);
    else if (verb == "stage")
      move(*rig_.stage, Length::of(number(words, "position")), description_.soft_stage, words, "mm",
           [](Length l) { return l.value(); });
    else if (verb == "platform")
      move(*rig_.platform, degrees(number(words, "angle")), description_.soft_platform, words,
           "deg", [](Angle a) { return to_degrees(a); });
    else if (verb == "where")
      where();
    else if (verb == "markers")
      markers(words);
    else if (verb == "leds")
      rig_.leds->set_all(number(words, "drive"), patience());
    else if (verb == "shoot")
      shoot(words);
    else if (verb == "measure")
      measure(words);
    else if (verb == "aim")
      aim(words);
    else if (verb == "off")
      make_safe(rig_);
    else
      throw ArgumentError("there is no command " + verb, "say help for the commands");
    return true;
  }

 private:
  Deadline patience(Duration expected = {}) const {
    return deadline_for(rig_.clock, expected, stop_.token());
  }

  void home(std::istringstream& words) {
    std::string what;
    words >> what;
    if (what == "platform")
      rig_.platform->home(patience(rig_.platform->home_duration()));
    else
      rig_.stage->home(patience(rig_.stage->home_duration()));
    where();
  }

  template <class P, class Units>
  void move(Stage<P>& stage, P target, const std::optional<std::array<P, 2>>& soft,
            std::istringstream& words, const char* unit, const Units& units) {
    std::string last;
    words >> last;
    if (soft && !(target >= (*soft)[0] && target <= (*soft)[1]) && last != "anyway")
      throw ArgumentError(fmt::format("{} {} is beyond the soft limits {} to {}", units(target),
                                      unit, units((*soft)[0]), units((*soft)[1])),
                          "add the word anyway if the way is free");
    const P reached = stage.move_to(target, patience(stage.move_duration(stage.travel())));
    fmt::print("stands at {:.3f} {}{}\n", units(reached), unit,
               stage.position_is_measured() ? "" : ", as commanded");
  }

  void where() {
    const auto tell = [&](const char* name, auto& stage, const char* unit, const auto& units) {
      const StageState state = stage.state();
      if (state == StageState::kIdle)
        fmt::print("{}: {:.3f} {}{}\n", name, units(stage.position(patience())), unit,
                   stage.position_is_measured() ? "" : ", as commanded");
      else
        fmt::print("{}: {}\n", name, to_string(state));
    };
    if (rig_.stage) tell("stage", *rig_.stage, "mm", [](Length l) { return l.value(); });
    if (rig_.platform)
      tell("platform", *rig_.platform, "deg", [](Angle a) { return to_degrees(a); });
    if (rig_.markers) {
      const MarkerLights::Mask mask = rig_.markers->state(patience());
      fmt::print("markers:");
      for (int i = 0; i < rig_.markers->count(); ++i)
        if (mask >> i & 1) fmt::print(" {}", i);
      fmt::print("{}\n", mask ? "" : " none");
    }
  }

  void markers(std::istringstream& words) {
    MarkerLights::Mask mask = 0;
    std::string word;
    if (!(words >> word)) throw ArgumentError("no marker is given", "say markers 0 2, all or none");
    do {
      int index = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (word == "all")
        mask = rig_.markers->all();
      else if (word == "none")
        mask = 0;
      else if (error != std::errc() || end != word.data() + word.size() || index < 0 || index > 31)
        throw ArgumentError("there is no marker " + word, "say markers 0 2, all or none");
      else
        mask |= MarkerLights::Mask{1} << index;
    } while (words >> word);
    rig_.markers->set(mask, patience());
  }

  void shoot(std::istringstream& words) {
    const Duration exposure = Duration::of(number(words, "exposure"));
    std::string file;
    if (!(words >> file)) throw ArgumentError("no file is given", "say shoot 0.01 out.png");
    const RawFrame frame =
        rig_.camera->expose(exposure, patience(rig_.camera->frame_duration(exposure)));
    write_mosaic_png(file, frame.mosaic);
    fmt::print("{}: {} x {} pixels, {:.6g} s\n", file, frame.mosaic.width(), frame.mosaic.height(),
               frame.exposure.value());
  }

  void measure(std::istringstream& words) {
    std::string file;
    words >> file;
    const Duration longest = rig_.spectroradiometer->range().longest_integration;
    const SpectralReading r = rig_.spectroradiometer->measure(patience(longest));
    const Eigen::Vector3d& xyz = r.xyz_cd_m2;
    if (r.below_floor)
      fmt::print("below the floor of {:g} cd/m²\n", rig_.spectroradiometer->range().floor_cd_m2);
    else
      fmt::print("{:.5g} cd/m², x {:.4f}, y {:.4f}\n", xyz.y(), xyz.x() / xyz.sum(),
                 xyz.y() / xyz.sum());
    if (file.empty()) return;
    std::string text = "wavelength_nm,radiance_w_sr_m2_nm\n";
    for (std::size_t i = 0; i < r.spectrum.values.size(); ++i)
      text += fmt::format("{:.6g},{:.6g}\n",
                          r.spectrum.first_nm + static_cast<double>(i) * r.spectrum.step_nm,
                          r.spectrum.values[i]);
    write_text_atomically(file, text);
    fmt::print("{}: {}\n", file, counted(r.spectrum.values.size(), "value"));
  }

  void aim(std::istringstream& words) {
    std::string what;
    words >> what;
    if (what != "on" && what != "off")
      throw ArgumentError("aim neither on nor off", "say aim on or aim off");
    rig_.spectroradiometer->aim(what == "on", patience());
  }

  const Rig& rig_;
  const RigDescription& description_;
  const StopOnSignal& stop_;
};

void jog(const std::string& file, const std::string& transcript, const ChaosOption& chaos) {
  const RigDescription description = read_rig_file(file, all_drivers());
  const StopOnSignal stop;
  RigSource source(description, transcript);
  chaos.arm(source.twin());
  const Rig rig = source.rig();
  const SafeAtExit guard(rig);
  Console console(rig, description, stop);
  const bool terminal = isatty(STDIN_FILENO);
  if (terminal) fmt::print("{}", kHelp);
  int failed = 0;
  for (std::string line; !stop.token().stop_requested();) {
    if (terminal) fmt::print("{}> ", description.name);
    std::fflush(stdout);
    if (!std::getline(std::cin, line)) break;
    try {
      if (!console.obey(line)) break;
    } catch (const Cancelled&) {
      throw;
    } catch (const Error& e) {
      ++failed;
      fmt::print(stderr, "{}\n", e.what());
    }
  }
  if (failed && !terminal)
    throw ArgumentError(fmt::format("{} of the commands failed", failed), "see the lines above");
}

}  // namespace

void add_jog(CLI::App& app) {
  auto* command = app.add_subcommand(
      "jog",
      "Move stages, switch lights, take frames and read the meter by hand, one command a line");
  auto rig = std::make_shared<std::string>();
  auto transcript = std::make_shared<std::string>();
  command->add_option("--rig", *rig, "rig file")->required();
  command->add_option("--transcript", *transcript, "writes what goes over the wires to this file");
  auto chaos = std::make_shared<ChaosOption>();
  chaos->add_to(*command);
  command->footer(std::string("Commands:\n") + kHelp +
                  "Example:\n  printf 'home\\nstage 50\\nwhere\\n' | wheatstone jog --rig "
                  "rigs/simulated.toml");
  command->callback([=] { jog(*rig, *transcript, *chaos); });
}

}  // namespace wheatstone::apps
