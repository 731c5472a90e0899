#include "sim/head_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace wheatstone {
namespace {

constexpr std::uint64_t kHeadSeed = 0x68656164ULL;  // apart from the devices' noise
constexpr double kBlinkEveryS = 4, kBlinkS = 0.15;

double seconds(Nanoseconds t) {
  return 1e-9 * static_cast<double>(t);
}

}  // namespace

Eigen::Vector3d SwayingHead::sway(Nanoseconds t, std::uint64_t what) const {
  constexpr std::array kHz = {0.13, 0.31, 0.77};
  constexpr std::array kAmplitude = {0.8, 0.4, 0.1};
  Eigen::Vector3d out;
  RandomStream random(seed_ ^ kHeadSeed, what);
  for (double& axis : out) {
    axis = 0;
    for (std::size_t i = 0; i < kHz.size(); ++i)
      axis +=
          kAmplitude[i] * std::sin(2 * std::numbers::pi * (kHz[i] * seconds(t) + random.uniform()));
  }
  return out;
}

Eigen::Vector3d SwayingHead::eye_rsb_mm(Eye eye, Nanoseconds t) const {
  constexpr double kTurnRad = 0.005;  // per unit of sway
  const Eigen::Vector3d left = true_eye_centre_rsb_mm(Eye::kLeft),
                        right = true_eye_centre_rsb_mm(Eye::kRight), middle = 0.5 * (left + right);
  const Eigen::Vector3d turn = kTurnRad * sway(t, 1);
  const Eigen::Vector3d arm = (eye == Eye::kLeft ? left : right) - middle;
  return middle + sway(t, 0) + arm + turn.cross(arm);
}

bool SwayingHead::eyes_closed(Nanoseconds t) const {
  const double window = std::floor(seconds(t) / kBlinkEveryS);
  RandomStream random(seed_ ^ kHeadSeed, stream_of({2, static_cast<std::uint64_t>(window)}));
  const double since =
      seconds(t) - kBlinkEveryS * window - random.uniform() * (kBlinkEveryS - kBlinkS);
  return since >= 0 && since < kBlinkS;
}

Nanoseconds SwayingHead::exposed_ns(std::uint32_t number) {
  return static_cast<Nanoseconds>(1e9 * number / kTrackerSamplesPerS);
}

std::array<std::optional<EyeCentre>, 2> SwayingHead::measured(std::uint32_t number) const {
  const Nanoseconds t = exposed_ns(number);
  if (eyes_closed(t)) return {};
  const Eigen::Vector3d sigma(kTrackerSigmaMm, kTrackerSigmaMm, kTrackerSigmaDepthMm);
  std::array<std::optional<EyeCentre>, 2> out;
  RandomStream random(seed_ ^ kHeadSeed, stream_of({3, number}));
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    EyeCentre e{eye_rsb_mm(eye, t), sigma.cwiseAbs2().asDiagonal(), 0.95};
    for (int i = 0; i < 3; ++i) e.p_rsb_mm[i] += sigma[i] * random.normal();
    out[eye == Eye::kLeft ? 0 : 1] = e;
  }
  return out;
}

EyeCentres SimulatedHeadTracker::next(Deadline deadline) {
  world_.faults.meet("tracker", deadline);
  const auto newest = static_cast<std::int64_t>(
      std::floor(seconds(world_.clock.now_ns() - kTrackerDelayNs) * kTrackerSamplesPerS));
  last_ = std::max(last_ + 1, newest);
  const auto number = static_cast<std::uint32_t>(last_);
  const Nanoseconds exposed = SwayingHead::exposed_ns(number), there = exposed + kTrackerDelayNs;
  if (there > deadline.at_ns) {
    --last_;
    world_.clock.wait_until(deadline.at_ns);
    throw DeviceError(DeviceError::Kind::kTimeout, "the simulated head tracker sends nothing new",
                      "allow at least the time between two samples");
  }
  world_.clock.wait_until(there);
  return {head_.measured(number), exposed};
}

}  // namespace wheatstone
