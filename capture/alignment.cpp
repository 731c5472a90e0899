#include "capture/alignment.h"

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr Duration kAlignLimit = Duration::of(60);

}  // namespace

void record_alignments(const Rig& rig, const Dataset& dataset, int settings) {
  if (settings < 1) throw ArgumentError("an alignment needs at least one setting", "ask for one");
  std::vector<std::vector<Alignment>> all;
  for (DisplayId id : kDisplays) {
    std::vector<Alignment> marks;
    for (const auto* points : {&rig.near_cross_positions_rsb_mm, &rig.marker_positions_rsb_mm})
      for (const Eigen::Vector3d& p : *points) {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (int i = 0; i < settings; ++i)
          sum += rig.observer->align(id, p, rig.clock.in(kAlignLimit));
        marks.push_back({p, sum / settings});
      }
    all.push_back(marks);
  }
  dataset.write_landmarks({rig.marker_positions_rsb_mm, rig.near_cross_positions_rsb_mm});
  dataset.write_displays(rig.panel_models);
  dataset.write_alignments(all);
}

}  // namespace wheatstone
