#include "apps/check.h"

#include "apps/stations.h"
#include "core/exr.h"
#include "core/files.h"
#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/ssim.h"
#include "rendering/metrics/viewing.h"

namespace wheatstone::apps {

std::array<EyeCheck, 2> check_at_eye(const Dataset& dataset, SimulatedRig& twin,
                                     std::optional<Luminance> limit) {
  Rig rig = twin.rig();
  rig.luminance_limit = limit;
  rig.markers->all_off();
  rig.leds->set_all(1, rig.clock.in(5.0_s));
  present(dataset, rig);
  make_folder(dataset.file("eye"));
  std::array<EyeCheck, 2> checks;
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    const PanelModel& far = rig.panel_models[index_of({eye, Plane::kFar})];
    const EyeCamera camera{far.lcd_width_px, far.lcd_height_px, 3};
    EyeCheck& check = checks[eye == Eye::kLeft ? 0 : 1];
    check.displays = twin.eye().photograph_displays(eye, camera);
    check.box = twin.eye().photograph_box(eye, camera);
    check.pu21_psnr_db = pu21_psnr_rgb(check.displays, check.box);
    check.difference_pu = pu21_difference(check.displays, check.box);
    check.pu21_ssim = pu21_ssim_luminance(check.displays, check.box);
    HdrVdp3Options viewing;
    viewing.pixels_per_degree =
        pixels_per_degree(Length::of(far.width_mm / far.lcd_width_px), far.distance);
    check.hdrvdp3_jod = hdr_vdp3(check.displays, check.box, viewing).q_jod;
    write_exr(dataset.file("eye/" + to_string(eye) + "_displays.exr"), check.displays);
    write_exr(dataset.file("eye/" + to_string(eye) + "_box.exr"), check.box);
  }
  rig.leds->all_off();
  return checks;
}

}  // namespace wheatstone::apps
