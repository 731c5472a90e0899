#include "hardware/display_outputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>
#include <map>

namespace wheatstone {
namespace {

constexpr double kRefreshSlackHz = 0.5;

/// What the wish leaves open fits everything.
bool fits(const EdidIdentity& wish, const EdidIdentity& edid) {
  return (wish.manufacturer.empty() || wish.manufacturer == edid.manufacturer) &&
         (wish.product == 0 || wish.product == edid.product) &&
         (wish.serial == 0 || wish.serial == edid.serial) &&
         (wish.name.empty() || wish.name == edid.name) &&
         (wish.serial_text.empty() || wish.serial_text == edid.serial_text);
}

/// `connector` empty: any.
std::vector<const DisplayOutput*> that_fit(const std::vector<DisplayOutput>& outputs,
                                           const EdidIdentity& wish, const std::string& connector) {
  std::vector<const DisplayOutput*> out;
  for (const DisplayOutput& o : outputs)
    if (fits(wish, o.edid) && (connector.empty() || connector == o.connector)) out.push_back(&o);
  return out;
}

std::string name_of(const EdidIdentity& e) {
  if (e == EdidIdentity{}) return "no EDID";
  return fmt::format("{} {} serial {}{}{}", e.manufacturer, e.product, e.serial,
                     e.name.empty() ? "" : " '" + e.name + "'",
                     e.serial_text.empty() ? "" : " '" + e.serial_text + "'");
}

std::string connectors(const std::vector<const DisplayOutput*>& outputs) {
  std::vector<std::string> names;
  for (const DisplayOutput* o : outputs) names.push_back(o->connector);
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

bool overlap(const DisplayOutput& a, const DisplayOutput& b) {
  return a.x_px < b.x_px + b.width_px && b.x_px < a.x_px + a.width_px &&
         a.y_px < b.y_px + b.height_px && b.y_px < a.y_px + a.height_px;
}

class Verification {
 public:
  Verification(const std::vector<DisplayOutput>& outputs, std::vector<OutputProblem>& problems)
      : outputs_(outputs), problems_(problems) {}

  void verify(const WantedOutput& wanted) {
    role_ = wanted.role;
    const DisplayOutput* output = bind(wanted);
    if (!output) return;
    if (const auto [it, fresh] = bound_.try_emplace(output, wanted.role); !fresh)
      add("one role", fmt::format("{} is {} already", output->connector, it->second),
          "say in the rig file which display is which");
    if (output->width_px != wanted.width_px || output->height_px != wanted.height_px)
      add("mode", fmt::format("{} x {} px", output->width_px, output->height_px),
          output->width_px == 0
              ? "switch the display on and give it its mode with xrandr"
              : fmt::format("set {} x {} with xrandr", wanted.width_px, wanted.height_px));
    if (wanted.refresh_hz > 0 &&
        !(std::abs(output->refresh_hz - wanted.refresh_hz) <= kRefreshSlackHz))
      add("refresh", fmt::format("{:g} Hz", output->refresh_hz),
          fmt::format("set {:g} Hz with xrandr", wanted.refresh_hz));
    if (output->bits_per_channel < wanted.bits_per_channel)
      add("depth", fmt::format("{} bits per channel", output->bits_per_channel),
          wanted.bits_per_channel == 10 ? "start the X server with depth 30"
                                        : "start the X server with the depth that is wanted");
    if (output->is_scaled)
      add("scaling", "a transform, border or scaling mode: pixels are not the panel's",
          "remove it with xrandr, and use the display's native mode");
    if (!output->gamma_is_identity)
      add("gamma", "a table that is not identity",
          "end what sets it (night light, colour management)");
    verify_link(*output, wanted);
  }

  /// Of displays that show the same part of the screen.
  void verify_apart() {
    for (auto a = bound_.begin(); a != bound_.end(); ++a)
      for (auto b = std::next(a); b != bound_.end(); ++b)
        if (overlap(*a->first, *b->first)) {
          role_ = a->second;
          add("apart", fmt::format("shares pixels with {}", b->second),
              "set the displays side by side with xrandr");
        }
  }

 private:
  void add(const char* check, const std::string& found, const std::string& remedy) {
    problems_.push_back({role_, check, found, remedy});
  }

  void verify_link(const DisplayOutput& output, const WantedOutput& wanted) {
    if (!output.dithering.empty() && output.dithering != "off")
      add("dithering", "the video driver's own: " + output.dithering,
          "switch it off (docs/hardware/display_outputs.md)");
    if (output.link_bits_per_channel > 0 && output.link_bits_per_channel < wanted.bits_per_channel)
      add("link depth", fmt::format("at most {} bits per channel", output.link_bits_per_channel),
          fmt::format("set \"max bpc\" to {} with xrandr", wanted.bits_per_channel));
    if (!output.range.empty() && output.range != "Full")
      add("range", output.range, "set \"Broadcast RGB\" to Full with xrandr");
    if (output.has_colour_matrix)
      add("colour matrix", "one that is not identity",
          "end what sets it (night light, colour management)");
  }

  /// Null: there is none, or none for certain.
  const DisplayOutput* bind(const WantedOutput& wanted) {
    const std::vector<const DisplayOutput*> alike = that_fit(outputs_, wanted.edid, ""),
                                            here =
                                                that_fit(outputs_, wanted.edid, wanted.connector);
    if (here.size() == 1) return here.front();
    if (here.size() > 1) {
      add("identity", fmt::format("{} answer alike", connectors(here)),
          "show each of them a number, and name the connector in the rig file");
    } else if (!alike.empty()) {
      add("connector",
          fmt::format("a display like it at {}, not at {}", connectors(alike), wanted.connector),
          "put the cable back, or confirm the new place and name it in the rig file");
    } else {
      std::string at = connectors({});
      for (const DisplayOutput& o : outputs_)
        if (o.connector == wanted.connector) at = name_of(o.edid) + " at " + o.connector;
      add("identity",
          wanted.connector.empty() ? fmt::format("no {}", name_of(wanted.edid))
                                   : fmt::format("{}, wanted at {}", at, wanted.connector),
          "switch the display on and check its cable");
    }
    return nullptr;
  }

  const std::vector<DisplayOutput>& outputs_;
  std::vector<OutputProblem>& problems_;
  std::map<const DisplayOutput*, std::string> bound_;
  std::string role_;
};

}  // namespace

std::vector<OutputProblem> verify(const std::vector<DisplayOutput>& outputs,
                                  const std::vector<WantedOutput>& wanted) {
  std::vector<OutputProblem> problems;
  Verification verification(outputs, problems);
  for (const WantedOutput& w : wanted) verification.verify(w);
  verification.verify_apart();
  return problems;
}

const DisplayOutput* find_output(const std::vector<DisplayOutput>& outputs,
                                 const WantedOutput& wanted) {
  const auto here = that_fit(outputs, wanted.edid, wanted.connector);
  return here.size() == 1 ? here.front() : nullptr;
}

std::string describe(const DisplayOutput& o) {
  return fmt::format(
      "{} at {}, dithering {}, {}, range {}", o.edid.name.empty() ? name_of(o.edid) : o.edid.name,
      o.connector, o.dithering.empty() ? "unknown" : o.dithering,
      o.link_bits_per_channel > 0 ? fmt::format("at most {} bits", o.link_bits_per_channel)
                                  : "bits unknown",
      o.range.empty() ? "unknown" : o.range);
}

bool is_identity_gamma(std::span<const std::uint16_t> table) {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (std::abs(table[i] - identity_gamma(i, table.size())) > 32) return false;  // half of 10 bits
  return table.size() >= 2;
}

int identity_gamma(std::size_t i, std::size_t size) {
  return static_cast<int>(
      std::lround(65535.0 * static_cast<double>(i) / static_cast<double>(size - 1)));
}

}  // namespace wheatstone
