#pragma once
// Lossless integer images (raw mosaics, drive levels) and pictures for people. 8- and 16-bit PNG.

#include <filesystem>
#include <functional>

#include "core/image.h"

namespace wheatstone {

/// 16-bit grey PNG. Errors: FileError.
void write_mosaic_png(const std::filesystem::path&, const MosaicImage&);
/// A 16-bit single-channel PNG, TIFF or PGM. Throws FileError for anything else.
MosaicImage read_mosaic_png(const std::filesystem::path&, BayerPattern);

/// 8-bit PNG, one channel or R, G, B.
void write_drive_png(const std::filesystem::path&, const DriveImage&);
DriveImage read_drive_png(const std::filesystem::path&);

/// sRGB picture of linear light with `white_cd_m2` at code 255; brighter light clips.
/// For people to look at, never to compute with.
cv::Mat3b to_srgb8(const RgbImage&, double white_cd_m2);  // channel order R, G, B
void write_picture_png(const std::filesystem::path&, const cv::Mat3b& rgb);
std::vector<unsigned char> encode_picture_png(const cv::Mat3b& rgb);

/// An 8- or 16-bit picture (JPEG, PNG, TIFF) as 8-bit grey, codes as stored, unrotated: for finding
/// features in it. Errors: FileError.
cv::Mat1b read_grey_picture(const std::filesystem::path&);

/// An 8- or 16-bit picture (JPEG, PNG, TIFF; grey becomes R = G = B) to linear light:
/// light_cd_m2(v) gives that of each channel's code, as a fraction v = 0..1 of the full code.
/// Errors: FileError: missing, damaged, other sample types.
RgbImage read_encoded_picture(const std::filesystem::path&,
                              const std::function<double(double)>& light_cd_m2);

/// An 8- or 16-bit sRGB picture (JPEG, PNG, TIFF; grey becomes R = G = B) to linear light with
/// `white_cd_m2` at full code. Errors: FileError; ArgumentError unless white_cd_m2 > 0.
RgbImage read_srgb_picture(const std::filesystem::path&, double white_cd_m2);

}  // namespace wheatstone
