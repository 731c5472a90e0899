#pragma once
// poses_bounds.npy of LLFF (Mildenhall et al. 2019).

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/import/pose_convention.h"

namespace wheatstone {

struct LlffModel {
  std::vector<ImportedView> views;
  std::vector<double> near_mm, far_mm;  // depth of the scene from each view
};

/// Reads <folder>/poses_bounds.npy: an N x 17 array of numbers, per view the 3x5 matrix
/// [R | centre | height, width, focal length] in rows and the two bounds. The pictures are those of
/// <folder>/images in the order of their names; their number must be N. One focal length, the
/// principal point in the middle, no distortion. Poses in `convention`, kLlffConvention if not
/// given. Lengths are multiplied by mm_per_unit. Errors: FileError: missing, damaged, another shape
/// or type of array, no rotation, another number of pictures. ArgumentError unless mm_per_unit > 0.
LlffModel read_llff(const std::filesystem::path& folder, double mm_per_unit = 1,
                    std::optional<PoseConvention> convention = std::nullopt);
/// The same from memory; `pictures` may be empty: then views are named by their number.
LlffModel parse_llff(std::span<const std::byte> npy, const std::filesystem::path& file,
                     const std::vector<std::filesystem::path>& pictures, double mm_per_unit = 1,
                     std::optional<PoseConvention> convention = std::nullopt);

/// Writes poses_bounds.npy atomically, lengths in mm. Errors: ArgumentError unless every view is
/// what the format can hold (see read_llff()) and 0 < near_mm < far_mm; FileError.
void write_llff(const std::filesystem::path& npy, std::span<const ImportedView>, double near_mm,
                double far_mm);

}  // namespace wheatstone
