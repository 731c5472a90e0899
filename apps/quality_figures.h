#pragma once
// The thesis's figures of MARRR, CaMoJAB and ALSaRR, drawn anew from the models.

#include <vector>

#include "apps/plot.h"
#include "rendering/motion_quality/alsarr/refresh_table.h"
#include "rendering/motion_quality/experiments.h"
#include "rendering/motion_quality/preset.h"

namespace wheatstone::apps {

/// Figure 3.4: best refresh rate, and resolution left, over speed for several budgets.
std::vector<Plot> marrr_optimum_figure(MotionQualityPreset);

/// Figure 5.6: CaMoJAB against the shading-rate experiment: one panel for each block and texture,
/// quality over shading rate, one colour for each speed. Lines are the model.
std::vector<Plot> shading_rate_figure(const QualityExperiments&, MotionQualityPreset);

/// Figure 5.7: CaMoJAB against refresh rates (experiments 1 and 3, Mackin, ITU) and ITU's
/// resolutions.
std::vector<Plot> refresh_rate_figure(const QualityExperiments&, MotionQualityPreset);

/// Figure 6.4: best refresh rate over speed for several budgets, and for the smallest of them the
/// quality at every rate, below the best, one line for each speed.
std::vector<Plot> refresh_table_figure(const RefreshTable&);

}  // namespace wheatstone::apps
