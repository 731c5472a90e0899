#include "core/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <half.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <functional>
#include <system_error>

#include "core/error.h"
#include "core/exr_file.h"
#include "core/files.h"

namespace wheatstone {
namespace {

constexpr float kMaxHalf = 65504.0F;

bool is_light(const Imf::Channel* channel) {
  return channel != nullptr && (channel->type == Imf::HALF || channel->type == Imf::FLOAT);
}

ExrMetadata metadata_of(const Imf::Header& header) {
  ExrMetadata out;
  if (Imf::hasWhiteLuminance(header)) {
    const double white = Imf::whiteLuminance(header);
    if (std::isfinite(white) && white > 0) out.white_luminance_cd_m2 = white;
  }
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities file = Imf::chromaticities(header), bt709;
    const auto near = [](const Imath::V2f& a, const Imath::V2f& b) {
      return (a - b).length() < 1e-3F;
    };
    out.has_bt709_chromaticities = near(file.red, bt709.red) && near(file.green, bt709.green) &&
                                   near(file.blue, bt709.blue) && near(file.white, bt709.white);
  }
  return out;
}

void require_writable_size(const cv::Mat& pixels) {
  if (pixels.empty()) throw ArgumentError("an empty image cannot be written", "");
  if (pixels.cols > detail::kMaxExrSide_px || pixels.rows > detail::kMaxExrSide_px ||
      static_cast<double>(pixels.total()) > detail::kMaxExrPixels)
    throw ArgumentError("the image is larger than 16384 x 16384 or 200 Mpixel",
                        "write it in pieces");
}

/// Opens the temporary itself, so that a full disk shows when the stream is closed: OpenEXR
/// writes its chunk table in a destructor, which cannot report.
void write_file(const std::filesystem::path& path, const Imf::Header& header,
                const std::function<void(Imf::OutputFile&)>& write_pixels) {
  write_atomically(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream stream(temporary, std::ios::binary);
    try {
      if (!stream) throw std::system_error(errno, std::generic_category());
      {
        Imf::StdOFStream exr_stream(stream, temporary.c_str());
        Imf::OutputFile file(exr_stream, header, 0);
        write_pixels(file);
      }
      stream.close();
      if (!stream) throw std::system_error(errno, std::generic_category());
    } catch (const std::exception& e) {
      throw FileError(path, std::string("cannot be written: ") + e.what(),
                      "check the folder, its permissions and the free space");
    }
  });
}

}  // namespace

RgbImage read_exr(const std::filesystem::path& path, ExrMetadata* metadata) {
  return detail::with_file_errors(path, [&] {
    const auto file = detail::open_exr(path);
    int part = 0;
    const auto has_rgb = [&](int i) {
      const Imf::ChannelList& list = file->header(i).channels();
      return is_light(list.findChannel("R")) && is_light(list.findChannel("G")) &&
             is_light(list.findChannel("B"));
    };
    while (part < file->parts() && !has_rgb(part)) ++part;
    if (part == file->parts())
      throw FileError(path, "has no channels R, G, B of type half or float",
                      "convert it to an RGB image");
    RgbImage image;
    cv::merge(detail::read_channels(path, *file, part, {"R", "G", "B"}), image.pixels);
    try {
      require_valid_radiance(image, "the image");
    } catch (const ArgumentError& e) {
      throw FileError(path, e.what(), "");
    }
    if (metadata != nullptr) *metadata = metadata_of(file->header(part));
    return image;
  });
}

void write_exr(const std::filesystem::path& path, const RgbImage& light_cd_m2,
               ExrPrecision precision) {
  const cv::Mat3f& pixels = light_cd_m2.pixels;
  require_writable_size(pixels);
  require_valid_radiance(light_cd_m2, path.string());
  const bool as_half = precision == ExrPrecision::kHalf;
  if (as_half) {
    double largest = 0;
    cv::minMaxLoc(pixels.reshape(1), nullptr, &largest);
    if (largest > kMaxHalf)
      throw ArgumentError(path.string() + ": a sample of " + std::to_string(largest) +
                              " cd/m^2 does not fit half precision (65504)",
                          "write float precision");
  }
  Imf::Header header(pixels.cols, pixels.rows);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is BT.709
  Imf::addWhiteLuminance(header, 1.0F);
  const Imf::PixelType type = as_half ? Imf::HALF : Imf::FLOAT;
  for (const char* name : {"R", "G", "B"}) header.channels().insert(name, Imf::Channel(type));

  write_file(path, header, [&](Imf::OutputFile& file) {
    // One row at a time through a row buffer: a row stride of 0 makes every row the same memory.
    const auto width = static_cast<std::size_t>(pixels.cols);
    std::vector<half> halves(as_half ? 3 * width : 0);
    std::vector<float> floats(as_half ? 0 : 3 * width);
    char* base =
        as_half ? reinterpret_cast<char*>(halves.data()) : reinterpret_cast<char*>(floats.data());
    const std::size_t sample_bytes = as_half ? sizeof(half) : sizeof(float);
    Imf::FrameBuffer buffer;
    std::size_t offset = 0;
    for (const char* name : {"R", "G", "B"}) {
      buffer.insert(name, Imf::Slice(type, base + offset, 3 * sample_bytes, 0));
      offset += sample_bytes;
    }
    file.setFrameBuffer(buffer);
    for (int r = 0; r < pixels.rows; ++r) {
      const float* row = pixels[r][0].val;
      if (as_half)
        std::copy(row, row + 3 * width, halves.begin());
      else
        std::copy(row, row + 3 * width, floats.begin());
      file.writePixels(1);
    }
  });
}

void write_exr(const std::filesystem::path& path, const ScalarImage& image,
               const std::string& channel) {
  require_writable_size(image.pixels);
  if (channel.empty()) throw ArgumentError("an EXR channel needs a name", "");
  Imf::Header header(image.width(), image.height());
  header.compression() = Imf::ZIP_COMPRESSION;
  if (channel == "Y") Imf::addWhiteLuminance(header, 1.0F);
  header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  write_file(path, header, [&](Imf::OutputFile& file) {
    Imf::FrameBuffer buffer;
    buffer.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(image.pixels.data),
                                      sizeof(float), image.pixels.step[0]));
    file.setFrameBuffer(buffer);
    file.writePixels(image.height());
  });
}

}  // namespace wheatstone
