#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace wheatstone {

/// The bytes of a V4L2 buffer: 12-bit codes in one of the formats of VideoFirmware, lines padded
/// with 0xa5. MJPG comes without Huffman tables, as most cameras send it.
std::vector<std::uint8_t> encode_pixels(const cv::Mat1w& codes, const std::string& format,
                                        std::uint32_t bytes_per_line);
/// Of one line without padding; 0 for MJPG; none of these formats: -1.
int line_bytes(const std::string& format, int width_px);

}  // namespace wheatstone
