#include "hardware/video/pixel_formats.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace wheatstone {
namespace {

enum class Coding { kBytes, kWords, kPacked10, kYuyv, kJpeg };

struct Format {
  const char* name;
  Coding coding;
  int bits = 8;
};

constexpr std::array kFormats = {
    Format{"GREY", Coding::kBytes},        Format{"RGGB", Coding::kBytes},
    Format{"GRBG", Coding::kBytes},        Format{"GBRG", Coding::kBytes},
    Format{"BA81", Coding::kBytes},        Format{"Y10 ", Coding::kWords, 10},
    Format{"Y12 ", Coding::kWords, 12},    Format{"Y16 ", Coding::kWords, 16},
    Format{"RG10", Coding::kWords, 10},    Format{"BA10", Coding::kWords, 10},
    Format{"GB10", Coding::kWords, 10},    Format{"BG10", Coding::kWords, 10},
    Format{"Y10P", Coding::kPacked10, 10}, Format{"pRAA", Coding::kPacked10, 10},
    Format{"pgAA", Coding::kPacked10, 10}, Format{"pGAA", Coding::kPacked10, 10},
    Format{"pBAA", Coding::kPacked10, 10}, Format{"YUYV", Coding::kYuyv},
    Format{"MJPG", Coding::kJpeg}};

const Format* find(const std::string& name) {
  const auto* f = std::find_if(kFormats.begin(), kFormats.end(),
                               [&](const Format& format) { return name == format.name; });
  return f == kFormats.end() ? nullptr : f;
}

std::uint8_t to_byte(double v) {
  return cv::saturate_cast<std::uint8_t>(v);
}

void unpack_words(const std::uint8_t* line, int bits, std::uint16_t* out, int width) {
  const auto mask = static_cast<std::uint16_t>((1U << bits) - 1);
  for (int x = 0; x < width; ++x)
    out[x] = static_cast<std::uint16_t>((line[2 * x] | line[2 * x + 1] << 8) & mask);
}

// Four pixels in five bytes: their high bytes, then the four low bit pairs, the first lowest.
void unpack_10(const std::uint8_t* line, std::uint16_t* out, int width) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* group = line + 5 * (x / 4);
    const int k = x % 4;
    out[x] = static_cast<std::uint16_t>(group[k] << 2 | (group[4] >> (2 * k) & 3));
  }
}

void unpack_yuyv(const std::uint8_t* line, bool full_range, cv::Vec3b* out, int width) {
  const double luma = full_range ? 1 : 255.0 / 219, chroma = full_range ? 1 : 255.0 / 224;
  for (int x = 0; x < width; ++x) {
    const std::uint8_t* pair = line + 4 * (x / 2);
    const double y = luma * (pair[2 * (x % 2)] - (full_range ? 0 : 16));
    const double u = chroma * (pair[1] - 128), v = chroma * (pair[3] - 128);
    out[x] = {to_byte(y + 1.402 * v), to_byte(y - 0.344136 * u - 0.714136 * v),
              to_byte(y + 1.772 * u)};
  }
}

// Whether this is a baseline JPEG of this size with its end. Its header is read before the decoder
// sees it, which would take any size and fill in what is missing.
bool is_whole_jpeg(std::span<const std::uint8_t> bytes, int width, int height) {
  std::size_t end = bytes.size();
  while (end > 0 && bytes[end - 1] == 0) --end;  // cameras pad
  if (end < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return false;
  if (bytes[end - 2] != 0xff || bytes[end - 1] != 0xd9) return false;
  bool sized = false;
  for (std::size_t at = 2; at + 4 <= end;) {
    if (bytes[at] != 0xff) return false;
    const int marker = bytes[at + 1];
    const auto length = static_cast<std::size_t>(bytes[at + 2] << 8 | bytes[at + 3]);
    if (length < 2 || at + 2 + length > end) return false;
    if (marker == 0xda) return sized;
    if (marker == 0xc0) {
      if (length < 8) return false;
      sized = (bytes[at + 5] << 8 | bytes[at + 6]) == height &&
              (bytes[at + 7] << 8 | bytes[at + 8]) == width;
      if (!sized) return false;
    } else if (marker > 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8) {
      return false;  // not baseline
    }
    at += 2 + length;
  }
  return false;
}

std::optional<cv::Mat> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height) {
  if (!is_whole_jpeg(bytes, width, height)) return {};
  const cv::Mat1b raw(1, static_cast<int>(bytes.size()), const_cast<std::uint8_t*>(bytes.data()));
  cv::Mat pixels;
  try {
    pixels = cv::imdecode(raw, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
  if (pixels.cols != width || pixels.rows != height) return {};
  cv::cvtColor(pixels, pixels, cv::COLOR_BGR2RGB);
  return pixels;
}

}  // namespace

bool is_known_format(const std::string& format) {
  return find(format) != nullptr;
}

std::size_t least_bytes_per_line(const std::string& format, int width_px) {
  const auto width = static_cast<std::size_t>(width_px);
  switch (find(format)->coding) {
    case Coding::kBytes:
      return width;
    case Coding::kWords:
      return 2 * width;
    case Coding::kPacked10:
      return (width + 3) / 4 * 5;
    case Coding::kYuyv:
      return (width + 1) / 2 * 4;
    case Coding::kJpeg:
      break;
  }
  return 0;
}

std::optional<cv::Mat> decode(const PixelLayout& layout, std::span<const std::uint8_t> bytes) {
  const Format& format = *find(layout.format);
  const int width = layout.width_px, height = layout.height_px;
  if (format.coding == Coding::kJpeg) return decode_jpeg(bytes, width, height);
  // The last line need not be padded.
  const std::size_t needed = static_cast<std::size_t>(height - 1) * layout.bytes_per_line +
                             least_bytes_per_line(layout.format, width);
  if (bytes.size() < needed) return {};

  cv::Mat pixels(height, width,
                 format.coding == Coding::kYuyv    ? CV_8UC3
                 : format.coding == Coding::kBytes ? CV_8UC1
                                                   : CV_16UC1);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* line = bytes.data() + static_cast<std::size_t>(y) * layout.bytes_per_line;
    if (format.coding == Coding::kBytes)
      std::copy_n(line, width, pixels.ptr<std::uint8_t>(y));
    else if (format.coding == Coding::kWords)
      unpack_words(line, format.bits, pixels.ptr<std::uint16_t>(y), width);
    else if (format.coding == Coding::kPacked10)
      unpack_10(line, pixels.ptr<std::uint16_t>(y), width);
    else
      unpack_yuyv(line, layout.full_range, pixels.ptr<cv::Vec3b>(y), width);
  }
  return pixels;
}

}  // namespace wheatstone
