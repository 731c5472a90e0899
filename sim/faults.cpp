#include "sim/faults.h"

#include <algorithm>
#include <array>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::array<std::optional<Kind>, 6> kAtRandom = {
    Kind::kTimeout, Kind::kDisconnected, Kind::kProtocol, Kind::kRefused, Kind::kFault, {}};
constexpr Duration kLongSleep = Duration::of(3600);

std::string problem_of(const std::string& device, Kind kind) {
  switch (kind) {
    case Kind::kTimeout:
      return "the simulated " + device + " did not answer in time";
    case Kind::kDisconnected:
      return "the simulated " + device + " is disconnected";
    case Kind::kProtocol:
      return "the simulated " + device + " sends nonsense";
    case Kind::kRefused:
      return "the simulated " + device + " refuses";
    default:
      return "the simulated " + device + " reports: " + to_string(kind);
  }
}

}  // namespace

double fault_probability(const std::string& profile) {
  if (profile == "rare") return 0.002;
  if (profile == "often") return 0.02;
  throw ArgumentError("there is no profile of faults " + profile, "use rare or often");
}

void FaultScript::arm(const std::string& device, Kind kind, int skipped) {
  armed_.push_back({device, kind, {}, skipped});
}

void FaultScript::step_clock(const std::string& device, Duration by, int skipped) {
  armed_.push_back({device, {}, by, skipped});
}

void FaultScript::arm_at_random(double probability, std::uint64_t seed) {
  if (!(probability >= 0 && probability <= 1))
    throw ArgumentError("a probability of faults is not in [0, 1]",
                        "use 0.01 for one in a hundred");
  probability_ = probability;
  random_ = RandomStream(seed, 0);
}

void FaultScript::meet(const std::string& device, const Deadline& deadline) {
  if (deadline.cancel.stop_requested()) throw Cancelled("the " + device + " was asked to stop");
  if (gone_.contains(device)) fail(device, Kind::kDisconnected, deadline);
  for (auto it = armed_.begin(); it != armed_.end(); ++it) {
    if (it->device != device || it->skipped-- > 0) continue;
    const Armed due = *it;
    armed_.erase(it);
    if (due.kind) fail(device, *due.kind, deadline);
    sleep(device, due.step, deadline);
    break;
  }
  if (probability_ > 0 && random_.uniform() < probability_) {
    const auto which = std::min(static_cast<std::size_t>(random_.uniform() * kAtRandom.size()),
                                kAtRandom.size() - 1);
    if (kAtRandom[which]) fail(device, *kAtRandom[which], deadline);
    sleep(device, kLongSleep, deadline);
  }
}

void FaultScript::sleep(const std::string& device, Duration by, const Deadline& deadline) {
  clock_.wait_until(clock_.in(by).at_ns);
  if (clock_.now_ns() > deadline.at_ns) fail(device, Kind::kTimeout, deadline);
}

void FaultScript::fail(const std::string& device, Kind kind, const Deadline& deadline) {
  if (kind == Kind::kTimeout) clock_.wait_until(deadline.at_ns);
  if (kind == Kind::kDisconnected) gone_[device] = true;
  throw DeviceError(kind, problem_of(device, kind),
                    kind == Kind::kDisconnected ? "plug it in again, then run the command again"
                                                : "run the command again");
}

}  // namespace wheatstone
