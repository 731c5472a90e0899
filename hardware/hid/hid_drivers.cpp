#include "hardware/hid/hid_drivers.h"

#include <algorithm>
#include <utility>

#include "hardware/hid/blink1.h"
#include "hardware/hid/relay_board.h"
#include "hardware/hid/relay_report.h"

namespace wheatstone {
namespace {

std::string relay_address(const std::string& board) {
  return board.empty() ? "" : "relay " + board;
}
std::string blink1_address(const std::string& serial) {
  return serial.empty() ? "" : "blink1 " + serial;
}

DevicePlan<MarkerLights> read_relay(const TomlTable& table) {
  RelayBoardSettings settings;
  settings.board = table.text("board");
  if (settings.board.size() != kRelayNameLength)
    table.fail("board", "is not five characters long", "give the name that usbrelay lists");
  settings.settle = Duration::of(table.number_or("settle_s", settings.settle.value(), 0, 1));
  return {"", relay_address(settings.board), "",
          [settings](RigContext& context) -> std::unique_ptr<MarkerLights> {
            RelayBoardSettings with_transcript = settings;
            with_transcript.transcript = context.transcript;
            return std::make_unique<RelayBoard>(with_transcript, context.deadline);
          }};
}

DevicePlan<MarkerLights> read_blink1(const TomlTable& table) {
  Blink1Settings settings;
  settings.serial = table.text("serial");
  if (table.has("colour")) {
    const auto colour = table.numbers<3>("colour", 0, 255);
    if (std::all_of(colour.begin(), colour.end(), [](double c) { return c < 1; }))
      table.fail("colour", "is black", "give red, green and blue, 0 to 255");
    for (std::size_t i = 0; i < colour.size(); ++i)
      settings.colour[i] = static_cast<std::uint8_t>(colour[i]);
  }
  return {"", blink1_address(settings.serial), "",
          [settings](RigContext& context) -> std::unique_ptr<MarkerLights> {
            Blink1Settings with_transcript = settings;
            with_transcript.transcript = context.transcript;
            return std::make_unique<Blink1>(with_transcript, context.deadline);
          }};
}

}  // namespace

void add_hid_drivers(DriverCatalogue& catalogue) {
  catalogue.add<MarkerLights>("hid-relay", read_relay);
  catalogue.add<MarkerLights>("blink1", read_blink1);
}

std::vector<HidLightFound> list_hid_lights() {
  std::vector<HidLightFound> out;
  const auto problem = [](const auto& found) {
    return found.trouble ? std::string(found.trouble->what()) : std::string();
  };
  for (const RelayBoardFound& f : list_relay_boards())
    out.push_back({relay_address(f.board), f.node.string(), problem(f)});
  for (const Blink1Found& f : list_blink1())
    out.push_back({blink1_address(f.serial), f.node.string(), problem(f)});
  for (HidLightFound& f : out)
    if (!f.address.empty() && f.problem.empty() &&
        std::count_if(out.begin(), out.end(),
                      [&](const auto& other) { return other.address == f.address; }) > 1)
      f.problem =
          "another one has the same identity; unplug one of them and rename it, if it can be";
  return out;
}

}  // namespace wheatstone
