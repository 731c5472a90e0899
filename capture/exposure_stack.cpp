#include "capture/exposure_stack.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/noise_profile.h"
#include "core/camera_raw.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/json.h"
#include "core/png.h"

namespace wheatstone {
namespace {

using nlohmann::json;

constexpr double kSafeShareOfRawWhite = 0.98;  // above it camera raw codes are no longer linear

bool is_camera_raw(const std::filesystem::path& file) {
  std::string extension = file.extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto ready_made = {".png", ".tif", ".tiff", ".pgm"};
  return std::find(ready_made.begin(), ready_made.end(), extension) == ready_made.end();
}

/// However they are written, links included.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code missing;
  return a.lexically_normal() == b.lexically_normal() || std::filesystem::equivalent(a, b, missing);
}

/// Calls read(), whose ArgumentError is about the key.
template <class Read>
auto of_key(const StrictObject& object, const std::string& key, const Read& read) {
  try {
    return read(object.text(key));
  } catch (const ArgumentError& e) {
    object.fail(key, std::string("is wrong: ") + e.what());
  }
}

/// The frame's own facts, where it is a camera raw file, and what frames.json says besides.
RawExposure read_raw_frame(const StrictObject& frame, const std::filesystem::path& file,
                           double& first_f_number, MergeOptions& merging, bool first) {
  const CameraRaw raw = read_camera_raw(file);
  const int saturation_dn = static_cast<int>(std::floor(kSafeShareOfRawWhite * raw.white_dn));
  if (first) {
    merging.black_dn = raw.black_dn;
    merging.saturation_dn = saturation_dn;
    first_f_number = raw.f_number;
  } else if (merging.saturation_dn != saturation_dn || merging.black_dn != raw.black_dn) {
    throw FileError(file, "has other black or white levels than the first frame",
                    "merge frames of one camera and one setting only");
  }
  RawExposure out{raw.mosaic, Duration::of(raw.exposure_s)};
  if (raw.iso > 0) out.gain = raw.iso / 100;
  if ((raw.f_number > 0) != (first_f_number > 0))
    throw FileError(file, "and the first frame do not both say their aperture",
                    "give frames of one lens");
  if (raw.f_number > 0) out.aperture_area = std::pow(first_f_number / raw.f_number, 2);
  if (raw.exposure_s <= 0 && !frame.has("exposure_s"))
    throw FileError(file, "does not say its exposure time", "give \"exposure_s\" in frames.json");
  return out;
}

}  // namespace

SensorNoise noise_from(const StrictObject& object, const std::filesystem::path& file) {
  const json& value = object.get("noise");
  if (value.is_string()) return read_noise_profile(file.parent_path() / object.text("noise")).noise;
  const StrictObject noise(value, file, "noise.", {"noise_k_rgb", "std_read", "std_adc"});
  const SensorNoise out{noise.numbers<3>("noise_k_rgb"), noise.number("std_read"),
                        noise.number("std_adc")};
  for (const double k : out.dn_per_electron)
    if (!(k > 0)) noise.fail("noise_k_rgb", "must hold numbers above 0");
  if (out.read_noise_e < 0) noise.fail("std_read", "must not be negative");
  if (out.adc_noise < 0) noise.fail("std_adc", "must not be negative");
  return out;
}

CodeRange code_range_from(const StrictObject& object) {
  CodeRange out;
  out.pattern = of_key(object, "pattern", bayer_pattern_from_string);
  out.bits = object.integer("bits", 1, 16);
  const int highest = (1 << out.bits) - 1;
  out.saturation_dn = object.has("saturation") ? object.integer("saturation", 1, highest) : highest;
  if (object.get("black").is_array())
    out.black_dn = object.numbers<4>("black");
  else
    out.black_dn.fill(object.number("black"));
  for (const double black : out.black_dn)
    if (!(black >= 0 && black < out.saturation_dn))
      object.fail("black", "must be at least 0 and below the saturated code");
  return out;
}

MosaicImage read_frame(const std::filesystem::path& file, const CodeRange& range) {
  MosaicImage out = read_mosaic_png(file, range.pattern);
  double highest = 0;
  cv::minMaxLoc(out.dn, nullptr, &highest);
  if (highest >= 1 << range.bits)
    throw FileError(file,
                    "holds the code " + std::to_string(static_cast<int>(highest)) + ", more than " +
                        std::to_string(range.bits) + " bits",
                    "correct \"bits\", or shift the codes down");
  return out;
}

ExposureStack read_exposure_stack(const std::filesystem::path& file) {
  const json document = read_json(file);
  const StrictObject top(
      document, file, "",
      {"pattern", "bits", "black", "saturation", "estimator", "noise", "frames"});
  ExposureStack out;
  if (top.has("estimator"))
    out.merging.estimator = of_key(top, "estimator", merge_estimator_from_string);
  if (top.has("noise")) out.merging.noise = noise_from(top, file);
  if (out.merging.estimator == MergeEstimator::kFullNoise && !out.merging.noise)
    top.fail("noise", "is missing, and the estimator \"full\" needs it");

  const json& frames = top.get("frames");
  if (!frames.is_array() || frames.empty()) top.fail("frames", "must be a list of frames");
  std::vector<StrictObject> entries;
  bool all_raw = true, all_ready_made = true;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    entries.emplace_back(
        frames[i], file, "frames[" + std::to_string(i) + "].",
        std::initializer_list<const char*>{"file", "exposure_s", "gain", "aperture_area"});
    out.files.push_back(file.parent_path() / entries[i].text("file"));
    for (std::size_t k = 0; k < i; ++k)
      if (same_file(out.files[k], out.files[i]))
        entries[i].fail("file", "is the file of frames[" + std::to_string(k) + "] too");
    (is_camera_raw(out.files[i]) ? all_ready_made : all_raw) = false;
    if (all_ready_made || entries[i].has("exposure_s")) entries[i].positive("exposure_s");
  }
  if (!all_raw && !all_ready_made)
    top.fail("frames", "mixes camera raw files with ready-made ones");
  CodeRange range;
  if (all_ready_made) {
    range = code_range_from(top);
    out.merging.black_dn = range.black_dn;
    out.merging.saturation_dn = range.saturation_dn;
  } else {
    for (const char* key : {"pattern", "bits", "black", "saturation"})
      if (top.has(key)) top.fail(key, "is said by the camera raw files themselves: leave it out");
  }

  double first_f_number = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const StrictObject& frame = entries[i];
    RawExposure e = all_raw
                        ? read_raw_frame(frame, out.files[i], first_f_number, out.merging, i == 0)
                        : RawExposure{read_frame(out.files[i], range), Duration::of(0)};
    if (frame.has("exposure_s")) e.exposure = Duration::of(frame.positive("exposure_s"));
    if (frame.has("gain")) e.gain = frame.positive("gain");
    if (frame.has("aperture_area")) e.aperture_area = frame.positive("aperture_area");
    if (i > 0 && e.frame.dn.size() != out.exposures[0].frame.dn.size())
      throw FileError(out.files[i],
                      "is " + std::to_string(e.frame.width()) + " x " +
                          std::to_string(e.frame.height()) + " px, the first frame " +
                          std::to_string(out.exposures[0].frame.width()) + " x " +
                          std::to_string(out.exposures[0].frame.height()),
                      "merge frames of one camera and one crop only");
    out.exposures.push_back(std::move(e));
  }
  return out;
}

LinearMosaic read_linear_mosaic(const std::filesystem::path& file, BayerPattern pattern) {
  if (file.extension() != ".exr") {
    LinearMosaic out{{}, pattern};
    read_mosaic_png(file, pattern).dn.convertTo(out.values, CV_32F);
    return out;
  }
  const std::vector<ExrView> views = read_exr_views(file);
  const ScalarImage* found = nullptr;
  int candidates = 0;
  for (const ExrView& view : views)
    for (const auto& [name, image] : view.channels)
      if (name.find('.') == std::string::npos) {
        found = &image;
        ++candidates;
      }
  if (candidates != 1)
    throw FileError(
        file, "has " + std::to_string(candidates) + " channels outside of layers, a mosaic has one",
        "give a picture that is not demosaiced yet");
  for (int r = 0; r < found->height(); ++r)
    for (int c = 0; c < found->width(); ++c)
      if (!std::isfinite(found->pixels(r, c)))
        throw FileError(file,
                        "holds a value that is not finite at column " + std::to_string(c) +
                            ", row " + std::to_string(r),
                        "make it again");
  return {found->pixels, pattern};
}

}  // namespace wheatstone
