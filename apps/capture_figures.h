#pragma once
// The plots of the report of a capture.

#include <string>
#include <vector>

#include "apps/capture_statistics.h"
#include "apps/plot.h"

namespace wheatstone::apps {

/// "1/60 s", or "2 s" from 0.4 s on.
std::string exposure_name(double s);

/// Which white light each exposure measures with green photosites, from the signal that is twice
/// its noise to saturation; and, unless `light_cd_m2` is empty, a histogram of the luminances there
/// are.
std::vector<Plot> exposure_ladder_figure(const CameraProfile&, const std::vector<ExposureRecord>&,
                                         const std::vector<float>& light_cd_m2);

/// Shares of the photosites of each view that are saturated and that are in the noise, along the
/// rail, a line for each exposure. `statistics`: of these views, in their order.
std::vector<Plot> clipping_figure(const std::vector<CapturedView>&,
                                  const std::vector<ViewStatistics>& statistics);

/// Histogram of the raw codes of a view, a line for each exposure.
Plot codes_figure(const CameraProfile&, const CapturedView&, const ViewStatistics&);

/// Noise against the model by signal, 95 % intervals. Errors: ArgumentError for fewer than two
/// levels.
Plot noise_figure(const ViewStatistics&);

}  // namespace wheatstone::apps
