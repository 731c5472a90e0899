#include "sim/faults.h"

#include <algorithm>
#include <array>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::array kAtRandom = {Kind::kTimeout, Kind::kDisconnected, Kind::kProtocol,
                                  Kind::kRefused, Kind::kFault};

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

void FaultScript::arm(const std::string& device, Kind kind, int skipped) {
  armed_.push_back({device, kind, skipped});
}

void FaultScript::arm_at_random(double probability, std::uint64_t seed) {
  if (!(probability >= 0 && probability <= 1))
    throw ArgumentError("a probability of faults is not in [0, 1]",
                        "use 0.01 for one in a hundred");
  probability_ = probability;
  random_ = RandomStream(seed, 0);
}

void FaultScript::arm_profile(const std::string& name, std::uint64_t seed) {
  if (name != "rare" && name != "often")
    throw ArgumentError("there is no profile of faults " + name, "use rare or often");
  arm_at_random(name == "rare" ? 0.002 : 0.02, seed);
}

void FaultScript::meet(const std::string& device, const Deadline& deadline) {
  if (deadline.cancel.stop_requested()) throw Cancelled("the " + device + " was asked to stop");
  if (gone_.contains(device)) fail(device, Kind::kDisconnected, deadline);
  for (auto it = armed_.begin(); it != armed_.end(); ++it) {
    if (it->device != device || it->skipped-- > 0) continue;
    const Kind kind = it->kind;
    armed_.erase(it);
    fail(device, kind, deadline);
  }
  if (probability_ > 0 && random_.uniform() < probability_)
    fail(device,
         kAtRandom[std::min<std::size_t>(
             static_cast<std::size_t>(random_.uniform() * kAtRandom.size()), kAtRandom.size() - 1)],
         deadline);
}

void FaultScript::fail(const std::string& device, Kind kind, const Deadline& deadline) {
  if (kind == Kind::kTimeout) clock_.wait_until(deadline.at_ns);
  if (kind == Kind::kDisconnected) gone_[device] = true;
  throw DeviceError(kind, problem_of(device, kind),
                    kind == Kind::kDisconnected ? "plug it in again, then run the command again"
                                                : "run the command again");
}

}  // namespace wheatstone
