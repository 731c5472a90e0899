#pragma once
// What a capture session shall expose, frame by frame, and what that will cost.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hardware/rig.h"

namespace wheatstone {

struct CapturePlan {
  int views = 11;  // evenly spaced over the rail, ends included; one view stands in its middle
  std::vector<double> exposures_s = {1 / 240.0, 1 / 60.0, 1 / 15.0};
  double marker_exposure_s = 1 / 60.0;
  double settle_s = 0;  // rest after every move, beyond the stage's own settling
  // What the exposures were planned for (exposure_planning.h); 0 where they were given by hand.
  double signal_to_noise = 0, coverage = 0;
};

/// Empty when the plan can be carried out, else the reason.
std::string validate(const CapturePlan&);

/// Throws ArgumentError for a plan that cannot be carried out, DeviceError kOutOfRange for an
/// exposure that the rig's camera does not offer.
void require_possible(const CapturePlan&, const Rig&);

/// Everything of the plan, for the session's journal `file`, which errors name (FileError).
nlohmann::json to_json(const CapturePlan&);
CapturePlan plan_from_json(const nlohmann::json&, const std::filesystem::path& file);

/// One line per entry that differs, "views: 11 there, 5 asked for"; empty for equal objects.
/// Nested names are joined by a slash.
std::string difference(const nlohmann::json& there, const nlohmann::json& asked);

/// One frame: where the carriage stands, from which side it came, what is lit.
struct Shot {
  enum class Light { kCeiling, kMarkers };
  enum class Approach { kFromBelow, kFromAbove };  // so that backlash is the same every time
  std::string view;                                // "view_000", ...; "return" for the last frame
  std::string file;                                // relative to the dataset's folder
  Length position;                                 // commanded
  Approach approach = Approach::kFromBelow;
  Light light = Light::kCeiling;
  double exposure_s = 0;
};
inline constexpr const char* kReturnView = "return";

/// In the order of capture: for each view, from one end of the rail to the other, its exposures
/// under the ceiling's light and one frame of the markers; with more than one view at the end a
/// second marker frame at the first position, reached from the other side, which shows backlash
/// and lost steps. Pre: a valid plan.
std::vector<Shot> shots_of(const CapturePlan&, Length travel);

struct CaptureForecast {
  int frames = 0;
  double duration_s = 0;
  // At most, with the camera's own files; lossless compression saves some of it.
  std::uintmax_t bytes = 0;
};
/// For the shots still to be taken, in order, by a carriage that has just been homed.
CaptureForecast forecast(const std::vector<Shot>&, const CapturePlan&, const Rig&);

}  // namespace wheatstone
