#include "hardware/hid/hid_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr int kTries = 3;

template <class Call>
auto with_tries(const Call& call) {
  for (int i = 1;; ++i) {
    try {
      return call();
    } catch (const DeviceError& e) {
      const bool may_pass =
          e.kind() == Kind::kFault || e.kind() == Kind::kProtocol || e.kind() == Kind::kRefused;
      if (!may_pass || i == kTries) throw;
    }
  }
}

}  // namespace

HidLights::HidLights(std::unique_ptr<HidDevice> device, About about)
    : about_(std::move(about)), device_(std::move(device)) {}

HidLights::~HidLights() {
  all_off();
}

void HidLights::set(Mask wanted, Deadline deadline) {
  if (wanted & ~all())
    throw DeviceError(
        Kind::kOutOfRange,
        fmt::format("{} has {} lights, and another one was asked for", device_->what(), count()),
        fmt::format("use bits 0 to {}", count() - 1));
  begin(deadline);
  try {
    with_tries([&] {
      write(wanted, deadline);
      if (const Mask lit = read(deadline); lit != wanted)
        throw DeviceError(Kind::kFault,
                          fmt::format("{} was to light {:#b} and says that it lights {:#b}",
                                      device_->what(), wanted, lit),
                          "check its supply and its relays");
    });
    if (steady_ != wanted) {
      steady_.reset();
      settle(deadline);
    }
    steady_ = wanted;
  } catch (...) {
    steady_.reset();
    all_off();
    throw;
  }
}

void HidLights::begin(const Deadline& deadline) {
  device_->check(deadline);
  if (!device_->allow_sends()) steady_.reset();
}

void HidLights::settle(const Deadline& deadline) {
  constexpr Nanoseconds kNapNs = 10'000'000;
  SteadyClock clock;
  const Nanoseconds steady_ns = clock.in(about_.settle).at_ns;
  while (clock.now_ns() < steady_ns) {
    device_->check(deadline);
    clock.wait_until(std::min({steady_ns, deadline.at_ns, clock.now_ns() + kNapNs}));
  }
  if (!device_->sends_allowed())
    throw DeviceError(Kind::kRefused, device_->what() + " was switched off meanwhile",
                      "run the command again");
}

MarkerLights::Mask HidLights::state(Deadline deadline) {
  begin(deadline);
  return with_tries([&] { return read(deadline); });
}

void HidLights::all_off() noexcept {
  device_->send_now(about_.off);
}

}  // namespace wheatstone
