#pragma once
// Numbers about raw frames, for the report of a capture.

#include <filesystem>
#include <string>
#include <vector>

#include "core/dataset.h"
#include "core/image.h"

namespace wheatstone::apps {

struct FrameStatistics {
  double saturated = 0, in_the_noise = 0;  // shares of the photosites
  double bin_dn = 1;
  std::vector<double> histogram;  // shares, from the black level up
};

/// How noisy photosites of one signal are.
struct NoiseLevel {
  double signal_dn = 0;  // above black, in the longer one of two exposures
  double measured_over_model = 0;
  double sigma = 0;  // standard deviation of measured_over_model
};

struct ViewStatistics {
  std::string name;
  std::vector<FrameStatistics> frames;  // in the order of the view's exposures
  std::vector<NoiseLevel> noise;        // by rising signal; empty for one exposure
};

/// Errors: FileError (missing or damaged frames).
ViewStatistics view_statistics(const Dataset&, const CapturedView&, const CameraProfile&);

/// The signal above black that is twice its own standard deviation, green photosites, ISO 100:
/// x = 2 sqrt(x k + (s_read^2 + s_adc^2) k^2).
double least_signal_dn(const CameraProfile&);

/// Of a merged file of light: which pixels are saturated even in the shortest exposure, and the
/// standard deviation of each one's luminance in percent of it (100 where there is no light); empty
/// if the file has none. Errors: FileError.
struct MergedTrust {
  cv::Mat1b saturated;  // 255 or 0
  ScalarImage deviation_percent;
};
MergedTrust merged_trust(const std::filesystem::path&);

}  // namespace wheatstone::apps
