#pragma once
// A merged view as an OpenEXR file: the picture, its standard deviation, and what to distrust.

#include <filesystem>

#include "capture/merge.h"

namespace wheatstone {

/// Writes, PIZ compressed, band by band, the picture and the layers of docs/hdr_merge.md:
///   picture      see the three functions
///   sigma.Y      standard deviation, float; missing when the noise parameters are unknown. Of the
///                photosite's own sample, DN/s at ISO 100; of light: luminance_deviation()
///   mask.saturated, mask.underexposed, mask.single_source   1 where true, else 0, half
///                (mask.underexposed comes with sigma.Y)
/// Errors: FileError; ArgumentError as of demosaic(), to_radiance() and half precision.

/// Picture: Y, the mosaic as it is, DN/s at ISO 100, float.
void write_merged_mosaic_exr(const std::filesystem::path&, const MergedMosaic&);

/// Picture: R, G, B, camera colours, DN/s at ISO 100, float; not clipped, so not light.
void write_merged_camera_exr(const std::filesystem::path&, const MergedMosaic&);

/// Picture: R, G, B, BT.709 light in cd/m^2, half, by the profile's colour response.
void write_merged_light_exr(const std::filesystem::path&, const MergedMosaic&,
                            const CameraProfile&);

}  // namespace wheatstone
