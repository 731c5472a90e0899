#include "sim/wire/video/pixel_encoder.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "sim/video_camera.h"

namespace wheatstone {
namespace {

constexpr std::uint8_t kPadding = 0xa5;

bool is_one_of(const std::string& format, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* n) { return format == n; });
}

std::vector<std::uint8_t> without_huffman_tables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const auto begin = jpeg.begin() + static_cast<std::ptrdiff_t>(at);
    if (jpeg[at + 1] == 0xda) {
      out.insert(out.end(), begin, jpeg.end());
      break;
    }
    const auto length = static_cast<std::size_t>(2 + (jpeg[at + 2] << 8 | jpeg[at + 3]));
    if (jpeg[at + 1] != 0xc4) out.insert(out.end(), begin, begin + static_cast<long>(length));
    at += length;
  }
  return out;
}

std::vector<std::uint8_t> encode_line(const cv::Mat1w& codes, int y, const std::string& format) {
  std::vector<std::uint8_t> out;
  const int width = codes.cols;
  if (is_one_of(format, {"GREY", "RGGB"})) {
    for (int x = 0; x < width; ++x) out.push_back(static_cast<std::uint8_t>(codes(y, x) >> 4));
  } else if (is_one_of(format, {"Y10P", "pRAA"})) {
    for (int x = 0; x < width; x += 4) {
      unsigned low = 0;
      for (int k = 0; k < 4; ++k) {
        const unsigned code = x + k < width ? codes(y, x + k) >> 2 : 0;
        out.push_back(static_cast<std::uint8_t>(code >> 2));
        low |= (code & 3) << (2 * k);
      }
      out.push_back(static_cast<std::uint8_t>(low));
    }
  } else if (format == "YUYV") {
    for (int x = 0; x < width; ++x) {
      out.push_back(static_cast<std::uint8_t>(16 + codes(y, x) * 219 / 4095));
      out.push_back(128);
    }
  } else {
    const cv::Mat1w words = video_pixels(codes, format == "RG10" ? "Y10 " : format);
    for (int x = 0; x < width; ++x) {
      out.push_back(static_cast<std::uint8_t>(words(y, x) & 0xff));
      out.push_back(static_cast<std::uint8_t>(words(y, x) >> 8));
    }
  }
  return out;
}

}  // namespace

int line_bytes(const std::string& format, int width_px) {
  if (is_one_of(format, {"GREY", "RGGB"})) return width_px;
  if (is_one_of(format, {"Y10P", "pRAA"})) return (width_px + 3) / 4 * 5;
  if (is_one_of(format, {"Y10 ", "Y12 ", "Y16 ", "RG10", "YUYV"})) return 2 * width_px;
  return format == "MJPG" ? 0 : -1;
}

std::vector<std::uint8_t> encode_pixels(const cv::Mat1w& codes, const std::string& format,
                                        std::uint32_t bytes_per_line) {
  if (format == "MJPG") {
    cv::Mat grey = video_pixels(codes, "GREY"), colour;
    cv::merge(std::vector<cv::Mat>(3, grey), colour);
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", colour, jpeg);
    return without_huffman_tables(jpeg);
  }
  std::vector<std::uint8_t> out;
  out.reserve(bytes_per_line * static_cast<std::size_t>(codes.rows));
  for (int y = 0; y < codes.rows; ++y) {
    const std::vector<std::uint8_t> line = encode_line(codes, y, format);
    out.insert(out.end(), line.begin(), line.end());
    out.resize(bytes_per_line * static_cast<std::size_t>(y + 1), kPadding);
  }
  return out;
}

}  // namespace wheatstone
