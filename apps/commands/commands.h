#pragma once
// The subcommands of `wheatstone`, one file each. Each function adds its command, whose callback
// does the work and throws wheatstone::Error when what was asked could not be done.

#include <CLI/App.hpp>

namespace wheatstone::apps {

void add_demo(CLI::App&);
void add_capture(CLI::App&);
void add_merge(CLI::App&);
void add_demosaic(CLI::App&);
void add_estimate_exposures(CLI::App&);
void add_measure_noise(CLI::App&);
void add_calibrate(CLI::App&);
void add_import(CLI::App&);
void add_render(CLI::App&);
void add_present(CLI::App&);
void add_doctor(CLI::App&);
void add_emulate(CLI::App&);
void add_jog(CLI::App&);
void add_leds(CLI::App&);
void add_report(CLI::App&);
void add_convert_camera(CLI::App&);
void add_export_poses(CLI::App&);
void add_metric(CLI::App&);
void add_quality(CLI::App&);

/// Below `wheatstone calibrate`.
void add_calibrate_camera(CLI::App& calibrate);
void add_calibrate_stereo(CLI::App& calibrate);
void add_calibrate_colour(CLI::App& calibrate);
void add_calibrate_leds(CLI::App& calibrate);

}  // namespace wheatstone::apps
