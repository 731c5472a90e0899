#include "capture/exposure_planning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "capture/merge.h"
#include "core/error.h"

namespace wheatstone {
namespace {

// Between the probed views a highlight may be brighter and a shadow darker; the probe itself knows
// the darkest light to a tenth.
constexpr double kHeadroom = 0.8, kDarkMargin = 0.9;
constexpr double kApart = 1.3;  // between neighbours: cameras name their times to a sixth stop
constexpr double kProbeStep = 8, kProbeStart_s = 1.0 / 60;
constexpr double kSeenElectrons = 100;  // of the darkest light, so that it is known to 10 %

double saturation_dn(const CameraProfile& camera) {
  return camera.white_dn - camera.black_dn;
}

/// Variance of one frame's read-out, electrons^2 at ISO 100.
double read_variance(const CameraProfile& camera) {
  return camera.read_noise_e * camera.read_noise_e + camera.adc_noise * camera.adc_noise;
}

/// x with x / sqrt(x + frames r^2) = wanted.
double electrons_needed(double wanted, int frames, const CameraProfile& camera) {
  const double s2 = wanted * wanted;
  return 0.5 * (s2 + std::sqrt(s2 * s2 + 4 * s2 * frames * read_variance(camera)));
}

std::vector<double> probed_positions_mm(const CapturePlan& plan, Length travel) {
  std::vector<double> all;
  for (const Shot& s : shots_of(plan, travel))
    if (s.view != kReturnView && (all.empty() || all.back() != s.position.value()))
      all.push_back(s.position.value());
  const std::set<std::size_t> chosen = {0, all.size() / 2, all.size() - 1};
  std::vector<double> out;
  for (const std::size_t i : chosen) out.push_back(all[i]);
  return out;
}

/// Light of one position from frames that grow shorter until none of it saturates, then longer.
class Probe {
 public:
  Probe(const Rig& rig, double coverage) : rig_(rig), coverage_(coverage) {}

  LightRange run(const std::stop_token& stop) {
    const ExposureLimits limits;
    const auto expose = [&](double t) {
      if (stop.stop_requested()) throw Cancelled("capture stopped");
      const Duration exposure = Duration::of(t);
      const Deadline deadline =
          deadline_for(rig_.clock, rig_.camera->frame_duration(exposure), stop);
      const RawFrame raw = rig_.camera->expose(exposure, deadline);
      stack_.push_back({raw.mosaic, raw.exposure, raw.gain});
    };
    double t = kProbeStart_s;
    expose(t);
    while (saturates(stack_.back()) && t / kProbeStep >= limits.shortest_s) expose(t /= kProbeStep);
    LightRange range = measure();
    for (t = kProbeStart_s * kProbeStep;
         t <= limits.longest_s && range.darkest_e_s * t / kProbeStep < kSeenElectrons;
         t *= kProbeStep) {
      expose(t);
      range = measure();
    }
    return range;
  }

 private:
  bool saturates(const RawExposure& e) const {
    double brightest = 0;
    cv::minMaxLoc(e.frame.dn, nullptr, &brightest);
    return brightest >= rig_.camera_profile.white_dn;
  }

  LightRange measure() const {
    const CameraProfile& camera = rig_.camera_profile;
    const cv::Mat1f merged = merge_exposures(stack_, merge_options(camera)).mosaic.values;
    LightRange range;
    cv::minMaxLoc(merged, nullptr, &range.brightest_dn_s);
    std::vector<float> electrons_s;
    electrons_s.reserve(merged.total());
    for (int r = 0; r < merged.rows; ++r)
      for (int c = 0; c < merged.cols; ++c) {
        const auto colour = static_cast<std::size_t>(bayer_colour(camera.pattern, r, c));
        electrons_s.push_back(merged(r, c) / static_cast<float>(camera.dn_per_electron[colour]));
      }
    const auto rank =
        electrons_s.begin() +
        static_cast<std::ptrdiff_t>((1 - coverage_) * static_cast<double>(electrons_s.size() - 1));
    std::nth_element(electrons_s.begin(), rank, electrons_s.end());
    range.darkest_e_s = kDarkMargin * std::max(0.0F, *rank);
    return range;
  }

  const Rig& rig_;
  double coverage_;
  std::vector<RawExposure> stack_;
};

}  // namespace

double signal_to_noise(double electrons, int frames, const CameraProfile& camera) {
  return electrons > 0 ? electrons / std::sqrt(electrons + frames * read_variance(camera)) : 0;
}

std::vector<double> plan_exposures(const LightRange& light, const CameraProfile& camera,
                                   double wanted, const ExposureLimits& limits) {
  if (!(wanted > 0) || !std::isfinite(wanted))
    throw ArgumentError("the signal-to-noise ratio must be above 0", "ask for 20 to 200");
  if (!(light.brightest_dn_s > 0) || !(light.darkest_e_s > 0))
    throw ArgumentError("the probe saw no light in the darkest part of the box",
                        "ask for a smaller coverage, or light the box");
  const double k = *std::max_element(camera.dn_per_electron.begin(), camera.dn_per_electron.end());
  const double full_e = saturation_dn(camera) / k;  // of the colour that holds fewest electrons
  double sum_s =
      std::min(limits.longest_s, kHeadroom * saturation_dn(camera) / light.brightest_dn_s);
  if (sum_s < limits.shortest_s)
    throw ArgumentError(fmt::format("the brightest light needs {:.2g} s, the camera's shortest "
                                    "exposure is {:.2g} s",
                                    sum_s, limits.shortest_s),
                        "dim the box, or close the aperture");
  std::vector<double> exposures = {sum_s};
  while (true) {
    const int frames = static_cast<int>(exposures.size());
    if (signal_to_noise(light.darkest_e_s * sum_s, frames, camera) >= (1 - 1e-9) * wanted)
      return exposures;  // what was just enough is not to fail by a rounding
    // Light that just saturates in the next frame is measured by the frames so far.
    const double longest_allowed = sum_s * full_e / electrons_needed(wanted, frames, camera);
    const double enough = electrons_needed(wanted, frames + 1, camera) / light.darkest_e_s - sum_s;
    const double next = std::min(longest_allowed, enough);
    if (longest_allowed < kApart * exposures.back())
      throw ArgumentError(fmt::format("a signal-to-noise ratio of {} is more than this camera "
                                      "reaches from exposure to exposure; just below saturation "
                                      "it is {:.0f}",
                                      wanted, signal_to_noise(full_e, 1, camera)),
                          "ask for less");
    if (next > limits.longest_s)
      throw ArgumentError(
          fmt::format(
              "the darkest light would need an exposure of {:.0f} s; in {} s it reaches a "
              "signal-to-noise ratio of {:.1f}",
              next, limits.longest_s,
              signal_to_noise(light.darkest_e_s * (sum_s + limits.longest_s), frames + 1, camera)),
          "ask for less or for a smaller coverage, or light the box");
    exposures.push_back(std::max(next, kApart * exposures.back()));
    sum_s += exposures.back();
  }
}

LightRange probe_light(const Rig& rig, const CapturePlan& plan, double coverage,
                       const std::stop_token& stop) {
  if (!(coverage > 0 && coverage < 1))
    throw ArgumentError("the coverage must lie between 0 and 1", "use 0.95");
  const SafeAtExit guard(rig);
  rig.stage->home(deadline_for(rig.clock, rig.stage->home_duration(), stop));
  rig.leds->set_all(rig.leds->max_mean_drive(), deadline_for(rig.clock, {}, stop));
  LightRange range{0, std::numeric_limits<double>::infinity()};
  for (const double mm : probed_positions_mm(plan, rig.stage->travel())) {
    rig.stage->move_to(
        Length::of(mm),
        deadline_for(rig.clock, rig.stage->move_duration(rig.stage->travel()), stop));
    const LightRange here = Probe(rig, coverage).run(stop);
    range.brightest_dn_s = std::max(range.brightest_dn_s, here.brightest_dn_s);
    range.darkest_e_s = std::min(range.darkest_e_s, here.darkest_e_s);
  }
  return range;
}

}  // namespace wheatstone
