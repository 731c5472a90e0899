#pragma once
// Whether a capture can be trusted, in a few sentences.

#include <string>
#include <vector>

#include "apps/capture_statistics.h"

namespace wheatstone::apps {

/// What is wrong, and what to do about it: sentences, and the command if one does it.
struct CaptureProblem {
  std::string what, remedy, command = {};
};

/// What is wrong with a captured folder; empty if nothing is:
/// views of which more than 1 % is saturated in the shortest exposure or in the noise of the
/// longest, noise beyond the camera's model, merges that are missing or damaged, a carriage that
/// did not come back, views that the poses leave out. `statistics`: of these views, in their order.
/// Errors: FileError (damaged files).
std::vector<CaptureProblem> capture_problems(const Dataset&, const std::vector<CapturedView>&,
                                             const std::vector<ViewStatistics>& statistics);

}  // namespace wheatstone::apps
