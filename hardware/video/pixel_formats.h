#pragma once
// From the bytes of a V4L2 buffer to pixels.

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>

namespace wheatstone {

/// As VIDIOC_G_FMT has it.
struct PixelLayout {
  std::string format;  // four characters
  int width_px = 0, height_px = 0;
  std::size_t bytes_per_line = 0;  // padding included; without meaning for MJPG
  bool full_range = true;          // YUYV: Y is 0..255, not 16..235
};

/// Whether decode() knows it.
bool is_known_format(const std::string& format);
/// Of one line without padding; 0 for compressed formats.
std::size_t least_bytes_per_line(const std::string& format, int width_px);

/// Pixels as VideoFrame has them, a copy. None if `bytes` do not hold a whole picture of this
/// layout: too few, or no baseline JPEG of this size with its end. Bits beyond a format's depth are
/// dropped. Pre: the format is known, bytes_per_line is at least the least.
/// Source: Linux media documentation, "Image Formats"; BT.601 for YUYV.
std::optional<cv::Mat> decode(const PixelLayout&, std::span<const std::uint8_t> bytes);

}  // namespace wheatstone
