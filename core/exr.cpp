#include "core/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <functional>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>

#include "core/error.h"
#include "core/exr_file.h"
#include "core/files.h"

namespace wheatstone {
namespace {

constexpr float kMaxHalf = 65504.0F;
constexpr int kBandRows = 256;  // whole chunks of any compression, some for every core

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

void require_writable(const ExrPicture& picture) {
  const cv::Size size = picture.size;
  if (size.empty()) throw ArgumentError("an empty image cannot be written", "");
  if (size.width > detail::kMaxExrSide_px || size.height > detail::kMaxExrSide_px ||
      static_cast<double>(size.width) * size.height > detail::kMaxExrPixels)
    throw ArgumentError("the image is larger than 16384 x 16384 or 200 Mpixel",
                        "write it in pieces");
  std::set<std::string> names;
  for (const ExrChannel& channel : picture.channels) {
    if (channel.name.empty()) throw ArgumentError("an EXR channel needs a name", "");
    if (!names.insert(channel.name).second)
      throw ArgumentError("EXR channel '" + channel.name + "' is given twice", "");
  }
  if (names.empty()) throw ArgumentError("an EXR file needs a channel", "");
}

Imf::Header header_of(const ExrPicture& picture) {
  Imf::Header header(picture.size.width, picture.size.height);
  header.compression() =
      picture.compression == ExrCompression::kPiz ? Imf::PIZ_COMPRESSION : Imf::ZIP_COMPRESSION;
  if (picture.is_light) {
    Imf::addChromaticities(header, Imf::Chromaticities());  // the default is BT.709
    Imf::addWhiteLuminance(header, 1.0F);
  }
  for (const ExrChannel& channel : picture.channels)
    header.channels().insert(
        channel.name,
        Imf::Channel(channel.precision == ExrPrecision::kHalf ? Imf::HALF : Imf::FLOAT));
  return header;
}

cv::Mat as_half(const std::filesystem::path& path, const ExrChannel& channel,
                const cv::Mat1f& values) {
  double lowest = 0, highest = 0;
  cv::minMaxLoc(values, &lowest, &highest);
  if (const double largest = std::max(highest, -lowest); largest > kMaxHalf)
    throw ArgumentError(path.string() + ": a sample of " + std::to_string(largest) +
                            " in channel " + channel.name + " does not fit half precision (65504)",
                        "write float precision");
  cv::Mat halves;
  values.convertTo(halves, CV_16F);
  return halves;
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
        Imf::OutputFile file(exr_stream, header, Imf::globalThreadCount());
        write_pixels(file);
      }
      stream.close();
      if (!stream) throw std::system_error(errno, std::generic_category());
    } catch (const Error&) {
      throw;
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

void write_exr_rows(const std::filesystem::path& path, const ExrPicture& picture,
                    const FillExrRows& fill) {
  require_writable(picture);
  static std::once_flag threads_started;
  std::call_once(threads_started, [] {
    Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency()));
  });
  const cv::Size size = picture.size;
  write_file(path, header_of(picture), [&](Imf::OutputFile& file) {
    std::vector<cv::Mat1f> floats(picture.channels.size());
    for (int first = 0; first < size.height; first += kBandRows) {
      const cv::Range rows(first, std::min(first + kBandRows, size.height));
      for (cv::Mat1f& band : floats) band.create(rows.size(), size.width);
      fill(rows, floats);
      Imf::FrameBuffer buffer;
      std::vector<cv::Mat> stored;  // alive until the band is written
      for (std::size_t i = 0; i < floats.size(); ++i) {
        const ExrChannel& channel = picture.channels[i];
        const bool half_precision = channel.precision == ExrPrecision::kHalf;
        stored.push_back(half_precision ? as_half(path, channel, floats[i]) : cv::Mat(floats[i]));
        const cv::Mat& band = stored.back();
        buffer.insert(channel.name, Imf::Slice::Make(half_precision ? Imf::HALF : Imf::FLOAT,
                                                     band.data, Imath::V2i(0, first), size.width,
                                                     rows.size(), band.elemSize(), band.step[0]));
      }
      file.setFrameBuffer(buffer);
      file.writePixels(rows.size());
    }
  });
}

void write_exr(const std::filesystem::path& path, const RgbImage& light_cd_m2,
               ExrPrecision precision) {
  const cv::Mat3f& pixels = light_cd_m2.pixels;
  require_valid_radiance(light_cd_m2, path.string());
  const ExrPicture picture{
      pixels.size(), {{"R", precision}, {"G", precision}, {"B", precision}}, true};
  write_exr_rows(path, picture, [&](cv::Range rows, std::span<cv::Mat1f> bands) {
    cv::split(pixels.rowRange(rows), bands.data());
  });
}

void write_exr(const std::filesystem::path& path, const ScalarImage& image,
               const std::string& channel) {
  const ExrPicture picture{image.pixels.size(), {{channel}}, channel == "Y"};
  write_exr_rows(path, picture, [&](cv::Range rows, std::span<cv::Mat1f> bands) {
    image.pixels.rowRange(rows).copyTo(bands[0]);
  });
}

}  // namespace wheatstone
