#pragma once

#include <filesystem>

#include "core/dataset.h"

namespace wheatstone::apps {

/// What a captured folder holds and how far it can be trusted, as one HTML page without links: a
/// verdict, the session and what disturbed it, thumbnails, exposure ladder, clipping, noise against
/// the model, deviations of the merged light, residuals of the poses and the rail. What has not
/// been made yet (merge, calibration) is said where it would stand. Errors: FileError (no capture,
/// damaged files).
void write_capture_report(const Dataset&, const std::filesystem::path& page);

}  // namespace wheatstone::apps
