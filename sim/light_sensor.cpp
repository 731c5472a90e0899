#include "sim/light_sensor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <sstream>

#include "core/random.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint64_t kDiodeSeed = 0x64696f6465ULL;  // apart from the other devices' noise
constexpr double kNoise = 0.001;                       // of full scale
constexpr int kSpotPx = 4;
constexpr double kLongestS = 1000;

}  // namespace

std::vector<std::uint16_t> PhotodiodeModel::samples(std::size_t count,
                                                    std::uint64_t recording) const {
  const ScalarImage light = luminance_cd_m2(world_.panel_light(id_));
  const double seen = cv::mean(light.pixels(cv::Rect(0, 0, kSpotPx, kSpotPx)))[0];
  const double level = gain_ * seen / (kPhotodiodeFullScale * world_.model(id_).peak_cd_m2);
  RandomStream random(world_.seed ^ kDiodeSeed, recording);
  std::vector<std::uint16_t> out(count);
  for (std::uint16_t& s : out)
    s = static_cast<std::uint16_t>(
        std::lround(65535 * std::clamp(level + kNoise * random.normal(), 0.0, 1.0)));
  return out;
}

LightTrace SimulatedLightSensor::record(Duration duration, Deadline deadline) {
  world_.faults.meet("light sensor", deadline);
  const double count = std::round(duration.value() * kPhotodiodeSamplesPerS);
  if (!(count >= 1 && duration.value() <= kLongestS)) {
    std::ostringstream problem;
    problem << "the simulated light sensor cannot record for " << duration.value() << " s";
    throw DeviceError(Kind::kOutOfRange, problem.str(), "use 0.0001 s to 1000 s");
  }
  LightTrace trace{world_.clock.now_ns(), kPhotodiodeSamplesPerS, {}};
  const Nanoseconds done = world_.clock.in(duration).at_ns;
  if (done > deadline.at_ns) {
    world_.clock.wait_until(deadline.at_ns);
    throw DeviceError(Kind::kTimeout, "the simulated light sensor did not send all samples in time",
                      "allow more than the time of the recording");
  }
  world_.clock.wait_until(done);
  for (const std::uint16_t s : diode_.samples(static_cast<std::size_t>(count), recordings_++)) {
    if (s == 65535)
      throw DeviceError(Kind::kTooBright, "the simulated light sensor is saturated",
                        "show darker patches, or cover the sensor in part");
    trace.levels.push_back(static_cast<float>(s) / 65535.0F);
  }
  return trace;
}

}  // namespace wheatstone
