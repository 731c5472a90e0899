#include "core/hdr_files.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string_view>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

constexpr int kMaxSide_px = 16384;
constexpr double kMaxPixels = 200e6;
constexpr const char* kDamaged = "make or copy the file again";

/// A file's bytes, taken from the front.
class Bytes {
 public:
  explicit Bytes(std::filesystem::path path) : path_(std::move(path)), bytes_(read_bytes(path_)) {}

  const std::filesystem::path& path() const { return path_; }
  std::size_t left() const { return bytes_.size() - at_; }

  unsigned next() {
    if (left() == 0) throw FileError(path_, "is shorter than its header promises", kDamaged);
    return std::to_integer<unsigned>(bytes_[at_++]);
  }
  const std::byte* take(std::size_t count) {
    if (count > left()) throw FileError(path_, "is shorter than its header promises", kDamaged);
    at_ += count;
    return bytes_.data() + at_ - count;
  }
  /// Up to and without the next byte for which stop() holds, which is taken too.
  template <class Stop>
  std::string text_until(Stop stop) {
    constexpr std::size_t kMaxLine = 4096;
    std::string out;
    while (left() > 0 && out.size() < kMaxLine) {
      const auto c = static_cast<char>(next());
      if (stop(c)) return out;
      out += c;
    }
    throw FileError(path_, "has a damaged header", kDamaged);
  }
  std::string line() {
    return text_until([](char c) { return c == '\n'; });
  }
  std::string word() {
    return text_until([](char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; });
  }

 private:
  std::filesystem::path path_;
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
};

/// The whole of `text` as a number.
template <class T>
bool parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

void require_readable_size(const std::filesystem::path& path, int width, int height) {
  if (width < 1 || height < 1) throw FileError(path, "has no pixels", kDamaged);
  if (width > kMaxSide_px || height > kMaxSide_px || 1.0 * width * height > kMaxPixels)
    throw FileError(path, "is larger than 16384 x 16384 or 200 Mpixel", "use a smaller image");
}

RgbImage checked(const std::filesystem::path& path, RgbImage image) {
  try {
    require_valid_radiance(image, "the image");
  } catch (const ArgumentError& e) {
    throw FileError(path, e.what(), "");
  }
  return image;
}

float stored_float(const std::byte* bytes, bool little_endian) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 4; ++i)
    bits |= std::to_integer<std::uint32_t>(bytes[i]) << 8 * (little_endian ? i : 3 - i);
  return std::bit_cast<float>(bits);
}

// ---- Radiance ----

using Rgbe = std::array<std::uint8_t, 4>;

/// What a Radiance header says that changes the light.
struct RadianceHeader {
  double exposure = 1;
  int width = 0, height = 0;
};

bool is_bt709(const std::string& primaries) {
  constexpr std::array<double, 8> kBt709 = {0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329};
  std::istringstream in(primaries);
  for (const double expected : kBt709) {
    double found = 0;
    if (!(in >> found) || std::abs(found - expected) > 1e-3) return false;
  }
  return true;
}

RadianceHeader read_radiance_header(Bytes& file) {
  RadianceHeader out;
  const std::string magic = file.line();
  if (!magic.starts_with("#?")) throw FileError(file.path(), "is no Radiance picture", kDamaged);
  for (std::string line = file.line(); !line.empty(); line = file.line()) {
    const auto equals = line.find('=');
    const std::string key = line.substr(0, equals),
                      value = equals == std::string::npos ? "" : line.substr(equals + 1);
    if (key == "FORMAT" && value != "32-bit_rle_rgbe")
      throw FileError(file.path(), "has pixels of format '" + value + "'",
                      "convert it to 32-bit_rle_rgbe");
    if (key == "EXPOSURE") {
      double exposure = 0;
      if (!parse(
              std::string_view(value).substr(std::min(value.find_first_not_of(' '), value.size())),
              exposure) ||
          !(exposure > 0) || !std::isfinite(exposure))
        throw FileError(file.path(), "has EXPOSURE '" + value + "'", "write a positive number");
      out.exposure *= exposure;
    }
    if (key == "COLORCORR")
      throw FileError(file.path(), "states a colour correction (COLORCORR)",
                      "write it without one");
    if (key == "PRIMARIES" && !is_bt709(value))
      throw FileError(file.path(), "has primaries other than BT.709 (" + value + ")",
                      "convert it to BT.709");
  }
  const std::string size = file.line();
  std::istringstream in(size);
  std::string y, x, rest;
  std::string height, width;
  if (!(in >> y >> height >> x >> width) || in >> rest || !parse(height, out.height) ||
      !parse(width, out.width))
    throw FileError(file.path(), "has the damaged size line '" + size.substr(0, 60) + "'",
                    kDamaged);
  if (y != "-Y" || x != "+X")
    throw FileError(file.path(), "is stored in the order '" + y + " " + x + "'",
                    "write it with -Y first, then +X");
  require_readable_size(file.path(), out.width, out.height);
  return out;
}

/// One row; its first pixel tells how it is stored.
void read_radiance_row(Bytes& file, std::vector<Rgbe>& row) {
  const auto next_pixel = [&] {
    Rgbe p{};
    std::memcpy(p.data(), file.take(4), 4);
    return p;
  };
  const Rgbe first = next_pixel();
  const std::size_t width = row.size();
  const bool coded =
      width >= 8 && width < 0x8000 && first[0] == 2 && first[1] == 2 && first[2] < 0x80;
  if (!coded) {
    row[0] = first;
    for (std::size_t i = 1; i < width; ++i) row[i] = next_pixel();
    for (const Rgbe& p : row)
      if (p[0] == 1 && p[1] == 1 && p[2] == 1)
        throw FileError(file.path(), "has rows run-length coded in the manner of before 1991",
                        "convert it with a current program");
    return;
  }
  if (std::size_t{first[2]} << 8 != (width & ~std::size_t{0xff}) || first[3] != (width & 0xff))
    throw FileError(file.path(), "has a row of another length", kDamaged);
  for (int component = 0; component < 4; ++component)
    for (std::size_t i = 0; i < width;) {
      const unsigned code = file.next();
      const bool run = code > 128;
      const std::size_t count = run ? code - 128 : code;
      if (count == 0 || count > width - i)
        throw FileError(file.path(), "has a damaged run length", kDamaged);
      const unsigned repeated = run ? file.next() : 0;
      for (std::size_t k = 0; k < count; ++k)
        row[i++][component] = static_cast<std::uint8_t>(run ? repeated : file.next());
    }
}

}  // namespace

RgbImage read_pfm(const std::filesystem::path& path) {
  Bytes file(path);
  const std::string magic = file.word();
  if (magic != "PF" && magic != "Pf") throw FileError(path, "is no Portable Float Map", kDamaged);
  int width = 0, height = 0;
  double scale = 0;
  if (!parse(file.word(), width) || !parse(file.word(), height) || !parse(file.word(), scale))
    throw FileError(path, "has a damaged header", kDamaged);
  require_readable_size(path, width, height);
  if (std::abs(scale) != 1)
    throw FileError(path,
                    "has a scale factor other than 1 and -1, on whose meaning programs differ",
                    "multiply the samples and write -1");
  const std::size_t channels = magic == "PF" ? 3 : 1;
  const std::size_t expected = 4 * channels * static_cast<std::size_t>(width) * height;
  if (file.left() != expected)
    throw FileError(path,
                    "holds " + std::to_string(file.left()) +
                        " bytes of pixels, its header promises " + std::to_string(expected),
                    kDamaged);
  RgbImage image(width, height);
  for (int r = height - 1; r >= 0; --r) {
    const std::byte* row = file.take(4 * channels * width);
    for (int c = 0; c < width; ++c)
      for (std::size_t k = 0; k < 3; ++k)
        image.pixels(r, c)[static_cast<int>(k)] =
            stored_float(row + 4 * (channels * c + std::min(k, channels - 1)), scale < 0);
  }
  return checked(path, image);
}

RgbImage read_radiance_hdr(const std::filesystem::path& path) {
  Bytes file(path);
  const RadianceHeader header = read_radiance_header(file);
  // The shortest row is four components of runs of 127.
  const double least =
      1.0 * header.height * std::min(4.0 * header.width, 4 + 8 * std::ceil(header.width / 127.0));
  if (static_cast<double>(file.left()) < least)
    throw FileError(path, "is shorter than its header promises", kDamaged);
  RgbImage image(header.width, header.height);
  std::vector<Rgbe> row(header.width);
  for (int r = 0; r < header.height; ++r) {
    read_radiance_row(file, row);
    for (int c = 0; c < header.width; ++c) {
      const Rgbe& p = row[c];
      const double unit = p[3] == 0 ? 0 : std::ldexp(1 / header.exposure, p[3] - (128 + 8));
      for (int k = 0; k < 3; ++k) image.pixels(r, c)[k] = static_cast<float>(p[k] * unit);
    }
  }
  return checked(path, image);
}

}  // namespace wheatstone
