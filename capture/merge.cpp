#include "capture/merge.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "capture/merge_cells.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr const char* kEstimatorNames[] = {"poisson", "full"};

std::string size_text(const MosaicImage& m) {
  return std::to_string(m.width()) + " x " + std::to_string(m.height()) + " px";
}

void require_positive(double value, const std::string& name, const std::string& quantity,
                      const std::string& remedy) {
  if (value > 0 && std::isfinite(value)) return;
  std::ostringstream problem;
  problem << name << " has " << quantity << " of " << value;
  throw ArgumentError(problem.str(), remedy);
}

void check(std::span<const RawExposure> stack) {
  if (stack.empty()) throw ArgumentError("no exposures to merge", "capture at least one frame");
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const std::string name = "exposure " + std::to_string(i);
    const RawExposure& e = stack[i];
    if (e.frame.dn.empty()) throw ArgumentError(name + " has no pixels", "capture it again");
    if (e.frame.dn.size() != stack[0].frame.dn.size())
      throw ArgumentError(
          name + " is " + size_text(e.frame) + " but exposure 0 is " + size_text(stack[0].frame),
          "merge frames of one camera and one crop only");
    if (e.frame.pattern != stack[0].frame.pattern)
      throw ArgumentError(name + " has the colour pattern " + to_string(e.frame.pattern) +
                              " but exposure 0 has " + to_string(stack[0].frame.pattern),
                          "merge frames of one camera and one crop only");
    require_positive(e.exposure.value(), name, "an exposure time in s",
                     "give its time in seconds, above 0");
    require_positive(e.gain, name, "a gain", "give ISO / 100, above 0");
    require_positive(e.aperture_area, name, "an aperture area",
                     "give it relative to the other frames, above 0");
    for (std::size_t j = 0; j < i; ++j)
      if (stack[j].scale_s() == e.scale_s() && stack[j].gain == e.gain)
        throw ArgumentError(name + " has the same time and gain as exposure " + std::to_string(j),
                            "leave one of them out, or check the times");
  }
}

void check(const MergeOptions& options) {
  for (const double black : options.black_dn)
    if (!(black < options.saturation_dn) || !std::isfinite(black))
      throw ArgumentError("the saturated code is not above the black level",
                          "check the black level and the white level");
  if (options.estimator == MergeEstimator::kFullNoise && !options.noise)
    throw ArgumentError("the full-noise estimator needs the noise parameters of the camera",
                        "give them, or use the estimator \"poisson\"");
  if (!options.noise) return;
  const SensorNoise& n = *options.noise;
  const auto bad = [](double v) { return !(v >= 0) || !std::isfinite(v); };
  if (bad(n.read_noise_e) || bad(n.adc_noise) ||
      std::any_of(n.dn_per_electron.begin(), n.dn_per_electron.end(),
                  [&](double k) { return bad(k) || k == 0; }))
    throw ArgumentError("the noise parameters of the camera are impossible",
                        "give three DN per electron above 0 and two deviations of at least 0");
}

}  // namespace

void check_exposures(std::span<const RawExposure> stack, const MergeOptions& options) {
  check(stack);
  check(options);
}

std::string to_string(MergeEstimator e) {
  return kEstimatorNames[static_cast<int>(e)];
}

MergeEstimator merge_estimator_from_string(const std::string& text) {
  for (int i = 0; i < 2; ++i)
    if (text == kEstimatorNames[i]) return static_cast<MergeEstimator>(i);
  throw ArgumentError("'" + text + "' is no estimator", "use poisson or full");
}

MergeOptions merge_options(const CameraProfile& camera) {
  MergeOptions out;
  out.black_dn.fill(camera.black_dn);
  out.saturation_dn = camera.white_dn;
  out.noise = camera.noise();
  return out;
}

MergedMosaic merge_exposures(std::span<const RawExposure> stack, const MergeOptions& options) {
  MergedMosaic out;
  merge_exposures(stack, options, out);
  return out;
}

void merge_exposures(std::span<const RawExposure> stack, const MergeOptions& options,
                     MergedMosaic& out) {
  check_exposures(stack, options);
  // The shortest first: it is the one that is always used. Of equal products, the shorter time.
  std::vector<const RawExposure*> order;
  for (const RawExposure& e : stack) order.push_back(&e);
  std::sort(order.begin(), order.end(), [](const RawExposure* a, const RawExposure* b) {
    return std::pair(a->scale_s(), a->exposure) < std::pair(b->scale_s(), b->exposure);
  });
  const cv::Size size = stack[0].frame.dn.size();
  out.mosaic.values.create(size);
  out.mosaic.pattern = stack[0].frame.pattern;
  if (options.noise)
    out.sigma_dn_s.create(size);
  else
    out.sigma_dn_s.release();
  out.flags.create(size);
  const auto merge_rows = [&](const cv::Range& cell_rows) {
    CellMerger merger(order, options);
    for (int i = cell_rows.start; i < cell_rows.end; ++i) merger.merge_row_of_cells(i, out);
  };
  cv::parallel_for_(cv::Range(0, (size.height + 1) / 2), merge_rows, 8.0 * cv::getNumThreads());
}

}  // namespace wheatstone
