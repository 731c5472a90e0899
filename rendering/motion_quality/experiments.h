#pragma once
// The measurements of motion quality that the models were fitted to and compared with.
// Source: thesis (UCAM-CL-TR-977), sections 3.4, 4.3 and 5.4.

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rendering/motion_quality/camojab.h"

namespace wheatstone {

/// In the order of the columns of the thesis's table 5.3.
enum class Experiment {
  kVrsPc,        // shading rates, four textures, JND
  kVrsMobile,    //
  kVrsVr,        //
  kRefreshRate,  // MARRR's experiment 1, predictable motion, JND
  kJudder,       // MARRR's experiment 3: judder alone, JND
  kMackin2016,   // refresh rates up to 2 kHz, mean opinion score 1..5
  kItuFps,       // ITU-R report on ultra-high definition: refresh rate, ...
  kItuPpd,       // ... and resolution
};
inline constexpr std::size_t kExperiments = 8;
inline constexpr std::array<const char*, kExperiments> kExperimentNames = {
    "PC", "Mobile", "VR", "Exp. 1", "Exp. 3", "Mackin", "ITU fps", "ITU ppd"};

/// The experiments in JND, on which models are fitted; the others only check them.
inline constexpr bool calibrates(Experiment e) {
  return e <= Experiment::kJudder;
}

struct QualityMeasurement {
  Experiment experiment;
  std::string texture;
  CamojabConditions conditions;
  double score = 0, score_low = 0, score_high = 0;  // with the experiment's own confidence limits
  std::size_t baseline = 0;  // the measurement whose quality counts as 0 in this comparison
};

struct QualityExperiments {
  std::vector<QualityMeasurement> measurements;
  std::map<std::string, CamojabTexture> textures;  // all that the measurements name

  std::vector<std::size_t> of(Experiment) const;  // indices, in the order of the files
};

/// Reads vrs_experiment_jnd.csv, marrr_experiment1_jnd.csv (its predictable conditions),
/// marrr_experiment3.csv and external_validation.csv from `data`, and NAME.exr for every texture
/// from `textures`. Speeds of the VRS experiment become |v - 2 deg/s|: its pictures also rotated.
/// Errors: FileError naming file, line and column; also for a comparison without its baseline.
QualityExperiments read_quality_experiments(const std::filesystem::path& data,
                                            const std::filesystem::path& textures);

}  // namespace wheatstone
