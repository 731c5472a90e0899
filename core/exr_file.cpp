#include "core/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <optional>

namespace wheatstone::detail {
namespace {

// A file of n bytes may ask for kBytesPerFileByte * n + kFreeBytes of pixels. DEFLATE, the densest
// general coder in the format, reaches 1032 : 1; the free part admits small or empty images of
// any coder (a constant DWA block is denser still).
constexpr double kBytesPerFileByte = 2000;
constexpr double kFreeBytes = 256.0 * 1024 * 1024;

// Keeps sums of window corners far from int overflow inside the library.
constexpr std::int64_t kMaxCoordinate_px = 1 << 24;
constexpr std::size_t kMaxNameBytes = 255;

struct Window {
  std::int64_t width = 0, height = 0;
};

/// What decides how much memory a part takes.
struct PartHeader {
  std::optional<Window> data, display, tile;
  std::optional<int> compression;
  std::string type;
  double bytes_per_pixel = 0;
  double channels = 0;
};

/// Walks the attributes of all headers, before the library is trusted with their sizes.
class HeaderWalk {
 public:
  explicit HeaderWalk(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status))
      throw FileError(path, "no such file", "check the name and the folder");
    if (!std::filesystem::is_regular_file(status))
      throw FileError(path, "is not a file", "name an OpenEXR image");
    const auto length = std::filesystem::file_size(path, error);
    stream_.open(path, std::ios::binary);
    if (error || !stream_) throw FileError(path, "cannot be opened", "check its permissions");
    length_ = static_cast<std::int64_t>(length);
  }

  void check() {
    if (u32() != 20000630) damaged("this is not an OpenEXR file");
    const std::uint32_t version = u32();
    if ((version & 0xff) != 2) damaged("unknown OpenEXR file version");
    const bool tiled = version & 0x200, multi_part = version & 0x1000;
    if (version & 0x800)
      throw FileError(path_, "holds deep samples",
                      "flatten it first, for example with a compositing program");
    double stored_bytes = 0, result_bytes = 0, table_bytes = 0;
    for (std::string name = text(); !name.empty(); name = text()) {
      PartHeader part;
      for (; !name.empty(); name = text()) attribute(name, part);
      if (!part.data || !part.display || !part.compression || part.channels == 0)
        damaged("the header lacks a data window, display window, compression or channel");
      check_part(part, multi_part ? part.type == "tiledimage" : tiled, stored_bytes, table_bytes);
      result_bytes += static_cast<double>(part.display->width) *
                      static_cast<double>(part.display->height) * part.channels * sizeof(float);
      if (!multi_part) break;
    }
    if (table_bytes > static_cast<double>(length_)) damaged("the file ends in its chunk table");
    require_plausible(stored_bytes);
    require_plausible(result_bytes);
  }

 private:
  [[noreturn]] void damaged(const std::string& problem) const {
    throw FileError(path_, problem, "make or copy the file again");
  }

  void require_plausible(double bytes) const {
    if (bytes > kFreeBytes + kBytesPerFileByte * static_cast<double>(length_))
      damaged("the file is far too short for the image its header promises");
  }

  void check_part(const PartHeader& part, bool tiled, double& stored_bytes, double& table_bytes) {
    const auto width = part.data->width, height = part.data->height;
    const double row_bytes = static_cast<double>(width) * part.bytes_per_pixel;
    stored_bytes += row_bytes * static_cast<double>(height);
    // The table and the chunks themselves (at least row and length) are 8 bytes each; for mipmaps
    // this counts the finest level only, which suffices as a lower bound.
    if (tiled) {
      if (!part.tile) damaged("a tiled image does not say its tile size");
      const auto across = (width + part.tile->width - 1) / part.tile->width;
      const auto down = (height + part.tile->height - 1) / part.tile->height;
      table_bytes += 16.0 * static_cast<double>(across) * static_cast<double>(down);
      // The library holds one row of tiles and whole tiles, however small the image is.
      require_plausible(static_cast<double>(std::max(width, part.tile->width)) *
                        static_cast<double>(part.tile->height) * part.bytes_per_pixel);
    } else {
      static constexpr std::array<int, 10> kLines = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      const int lines = kLines[static_cast<std::size_t>(*part.compression)];
      table_bytes += 16.0 * static_cast<double>((height + lines - 1) / lines);
      require_plausible(row_bytes * lines);
    }
  }

  void attribute(const std::string& name, PartHeader& part) {
    const std::string type = text();
    const std::int64_t size = static_cast<std::int32_t>(u32());
    const std::int64_t begin = stream_.tellg();
    if (size < 0 || size > length_ - begin) damaged("the header is cut off");
    if (name == "dataWindow") {
      window(name, type, size, part.data);
    } else if (name == "displayWindow") {
      window(name, type, size, part.display);
    } else if (name == "tiles") {
      if (type != "tiledesc" || size != 9 || part.tile) damaged("bad attribute 'tiles'");
      const std::int64_t w = u32(), h = u32();
      if (w < 1 || h < 1 || w > kMaxExrSide_px || h > kMaxExrSide_px) damaged("bad tile size");
      part.tile = Window{w, h};
    } else if (name == "compression") {
      if (type != "compression" || size != 1 || part.compression)
        damaged("bad attribute 'compression'");
      part.compression = byte();
      if (*part.compression > 9) damaged("unknown compression");
    } else if (name == "type") {
      if (type != "string" || static_cast<std::size_t>(size) > kMaxNameBytes || !part.type.empty())
        damaged("bad attribute 'type'");
      for (std::int64_t i = 0; i < size; ++i) part.type += static_cast<char>(byte());
    } else if (name == "channels") {
      if (type != "chlist" || part.channels > 0) damaged("bad attribute 'channels'");
      while (!text().empty()) {
        const std::uint32_t sample = u32();  // 0 unsigned, 1 half, 2 float
        if (sample > 2) damaged("unknown sample type");
        part.bytes_per_pixel += sample == 1 ? 2 : 4;
        part.channels += 1;
        stream_.seekg(12, std::ios::cur);  // linearity, reserved, sampling
      }
      if (stream_.tellg() != begin + size) damaged("bad attribute 'channels'");
    }
    stream_.seekg(begin + size);
  }

  void window(const std::string& name, const std::string& type, std::int64_t size,
              std::optional<Window>& out) {
    if (type != "box2i" || size != 16 || out) damaged("bad attribute '" + name + "'");
    std::array<std::int64_t, 4> v{};  // x_min, y_min, x_max, y_max
    for (auto& x : v) {
      x = static_cast<std::int32_t>(u32());
      if (x < -kMaxCoordinate_px || x > kMaxCoordinate_px) damaged("bad " + name);
    }
    const Window w{v[2] - v[0] + 1, v[3] - v[1] + 1};
    if (w.width < 1 || w.height < 1) damaged("the " + name + " is empty");
    if (w.width > kMaxExrSide_px || w.height > kMaxExrSide_px ||
        static_cast<double>(w.width) * static_cast<double>(w.height) > kMaxExrPixels)
      throw FileError(path_, "the " + name + " is larger than 16384 x 16384 or 200 Mpixel",
                      "use a smaller image");
    out = w;
  }

  std::uint8_t byte() {
    const int c = stream_.get();
    if (c == std::char_traits<char>::eof()) damaged("the file ends in its header");
    return static_cast<std::uint8_t>(c);
  }
  std::uint32_t u32() {
    std::uint32_t v = 0;
    for (int shift = 0; shift < 32; shift += 8) v |= std::uint32_t{byte()} << shift;
    return v;
  }
  std::string text() {
    std::string out;
    for (std::uint8_t c = byte(); c != 0; c = byte()) {
      out += static_cast<char>(c);
      if (out.size() > kMaxNameBytes) damaged("a name in the header is too long");
    }
    return out;
  }

  std::filesystem::path path_;
  std::ifstream stream_;
  std::int64_t length_ = 0;
};

}  // namespace

std::unique_ptr<Imf::MultiPartInputFile> open_exr(const std::filesystem::path& path) {
  HeaderWalk(path).check();
  // Reconstructing lost chunk tables is left out: it searches the whole file for every chunk.
  auto file = std::make_unique<Imf::MultiPartInputFile>(path.c_str(), 0, false);
  for (int i = 0; i < file->parts(); ++i) {
    const Imf::Header& header = file->header(i);
    if (header.hasType() && header.type() != "scanlineimage" && header.type() != "tiledimage")
      throw FileError(path, "holds deep or unknown parts",
                      "flatten it first, for example with a compositing program");
    if (!file->partComplete(i))
      throw FileError(path, "is incomplete: pixels are missing", "make or copy the file again");
  }
  return file;
}

std::vector<cv::Mat1f> read_channels(const std::filesystem::path& path,
                                     Imf::MultiPartInputFile& file, int part,
                                     const std::vector<std::string>& channels) {
  const Imf::Header& header = file.header(part);
  const Imath::Box2i data = header.dataWindow(), display = header.displayWindow();
  const cv::Rect data_rect(data.min.x - display.min.x, data.min.y - display.min.y,
                           data.max.x - data.min.x + 1, data.max.y - data.min.y + 1);
  const cv::Rect display_rect(0, 0, display.max.x - display.min.x + 1,
                              display.max.y - display.min.y + 1);
  Imf::FrameBuffer buffer;
  std::vector<cv::Mat1f> out;
  for (const std::string& name : channels) {
    const Imf::Channel& channel = header.channels()[name];
    if (channel.xSampling != 1 || channel.ySampling != 1)
      throw FileError(path, "channel '" + name + "' is subsampled",
                      "store it with one sample per pixel");
    out.emplace_back(data_rect.size(), 0.0F);
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, out.back().data, data, sizeof(float),
                                         out.back().step[0]));
  }
  Imf::InputPart input(file, part);
  input.setFrameBuffer(buffer);
  input.readPixels(data.min.y, data.max.y);
  if (data_rect == display_rect) return out;

  const cv::Rect common = data_rect & display_rect;
  for (cv::Mat1f& pixels : out) {
    cv::Mat1f placed(display_rect.size(), 0.0F);
    if (!common.empty()) pixels(common - data_rect.tl()).copyTo(placed(common));
    pixels = placed;
  }
  return out;
}

}  // namespace wheatstone::detail
