#include "hardware/hid/relay_board.h"

#include <fmt/format.h>

#include "core/error.h"
#include "hardware/hid/relay_report.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint16_t kVendor = 0x16c0, kProduct = 0x05df;
constexpr Duration kAskLimit = Duration::of(1);
constexpr std::uint8_t kAnyReport = 1;  // boards do not look at it
constexpr std::size_t kLongestReport = 9;

RelayReport ask(HidDevice& device, const Deadline& deadline) {
  const std::string bytes = device.get_feature(kAnyReport, kLongestReport, deadline);
  const std::optional<RelayReport> report = parse_relay_report(bytes);
  if (!report)
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} sent a report that is none of a relay board's ({})",
                                  device.what(), hex_of(bytes)),
                      "unplug it and plug it in again");
  return *report;
}

std::vector<RelayBoardFound> boards(const Deadline& deadline) {
  std::vector<RelayBoardFound> out;
  for (const HidFound& d : list_hid_devices(kVendor, kProduct)) {
    RelayBoardFound board{d.node, "", relay_channels(d.product), std::nullopt};
    if (board.channels == 0) continue;  // the id is shared with other things
    try {
      HidDevice device("the relay board on " + d.node.string(), d.node, HidDevice::Use::kLook);
      board.board = ask(device, deadline).board;
      if (device.owned())
        board.trouble = DeviceError(Kind::kBusy, device.what() + " is in use by another program",
                                    "end that program");
    } catch (const DeviceError& e) {
      board.trouble = e;
    }
    out.push_back(std::move(board));
  }
  return out;
}

/// The only one with this name.
RelayBoardFound find(const RelayBoardSettings& settings, const Deadline& deadline) {
  if (!(settings.settle.value() >= 0 && settings.settle.value() <= 1))
    throw ArgumentError("relays cannot take so long to settle", "use 0 to 1 s");
  const std::string& name = settings.board;
  if (name.size() != kRelayNameLength)
    throw ArgumentError(fmt::format("'{}' is no name of a relay board", printable(name)),
                        "give the five characters that `wheatstone doctor` or usbrelay lists");
  std::optional<RelayBoardFound> found;
  std::optional<DeviceError> trouble;
  for (const RelayBoardFound& board : boards(deadline)) {
    if (board.board.empty() && !trouble) trouble = board.trouble;
    if (board.board != name) continue;
    if (found)
      throw DeviceError(
          Kind::kNotFound,
          fmt::format("the relay boards on {} and {} both have the name '{}'", found->node.string(),
                      board.node.string(), name),
          fmt::format("unplug one, rename the other (usbrelay {}_0=NEW01) and name it so in the "
                      "rig file",
                      name));
    found = board;
  }
  if (found) return *found;
  if (trouble) throw *trouble;  // it may be the one
  throw DeviceError(Kind::kNotFound, fmt::format("no relay board has the name '{}'", name),
                    "plug it in, or correct its name in the rig file");
}

}  // namespace

std::vector<RelayBoardFound> list_relay_boards() {
  return boards(SteadyClock().in(kAskLimit));
}

RelayBoard::RelayBoard(const RelayBoardSettings& settings, const Deadline& deadline)
    : RelayBoard(settings, find(settings, deadline), deadline) {}

RelayBoard::RelayBoard(const RelayBoardSettings& settings, const RelayBoardFound& found,
                       const Deadline& deadline)
    : HidLights(std::make_unique<HidDevice>(fmt::format("relay board {}", settings.board),
                                            found.node, HidDevice::Use::kOwn, settings.transcript),
                {{"hid-relay", fmt::format("USBRelay{}", found.channels), settings.board, "",
                  found.node.string()},
                 found.channels,
                 settings.settle,
                 relay_order_all(false)}),
      board_(settings.board) {
  set(0, deadline);  // a board keeps what it lit when its last program died
}

void RelayBoard::write(Mask wanted, const Deadline& deadline) {
  if (wanted == 0 || wanted == all()) {
    device().send_feature(relay_order_all(wanted != 0), deadline);
    return;
  }
  const Mask lit = read(deadline);
  for (int i = 0; i < count(); ++i)
    if ((wanted ^ lit) >> i & 1)
      device().send_feature(relay_order(i + 1, wanted >> i & 1), deadline);
}

MarkerLights::Mask RelayBoard::read(const Deadline& deadline) {
  const RelayReport report = ask(device(), deadline);
  if (report.board != board_)
    throw DeviceError(Kind::kFault, fmt::format("{} answers as {}", device().what(), report.board),
                      "give every board its own name");
  if (report.on & ~all())
    throw DeviceError(
        Kind::kProtocol,
        fmt::format("{} has {} channels and says that another one is on", device().what(), count()),
        "unplug it and plug it in again");
  return report.on;
}

}  // namespace wheatstone
