#include "sim/wire/still/dng.h"

#include <bit>

#include "sim/wire/still/little_endian.h"

namespace wheatstone {
namespace {

static_assert(std::endian::native == std::endian::little);  // codes are copied as they are

enum Type : std::uint16_t {
  kByte = 1,
  kAscii = 2,
  kShort = 3,
  kLong = 4,
  kRational = 5,
  kSignedRational = 10
};

/// One image file directory (TIFF 6.0, section 2). Values longer than four bytes follow it.
class Directory {
 public:
  /// Pre: tags in ascending order.
  template <class T>
  void add(std::uint16_t tag, Type type, std::size_t count, const std::vector<T>& values) {
    Entry entry{tag, type, static_cast<std::uint32_t>(count), {}};
    for (const T value : values) append(entry.value, value);
    entries_.push_back(std::move(entry));
  }
  void add_short(std::uint16_t tag, std::uint16_t value) {
    add<std::uint16_t>(tag, kShort, 1, {value});
  }
  void add_long(std::uint16_t tag, std::size_t value) {
    add<std::uint32_t>(tag, kLong, 1, {static_cast<std::uint32_t>(value)});
  }
  void add_text(std::uint16_t tag, const std::string& text) {
    std::vector<char> bytes(text.begin(), text.end());
    bytes.push_back('\0');
    add(tag, kAscii, bytes.size(), bytes);
  }

  std::size_t size() const {
    std::size_t bytes = 2 + 12 * entries_.size() + 4;
    for (const Entry& e : entries_) bytes += e.apart();
    return bytes;
  }
  /// Pre: `out` holds `at` bytes.
  void write(std::vector<std::byte>& out, std::size_t at) const {
    std::size_t values_at = at + 2 + 12 * entries_.size() + 4;
    append(out, static_cast<std::uint16_t>(entries_.size()));
    for (const Entry& e : entries_) {
      append(out, e.tag);
      append(out, static_cast<std::uint16_t>(e.type));
      append(out, e.count);
      std::vector<std::byte> field = e.value;
      if (e.apart() > 0) {
        field.clear();
        append(field, static_cast<std::uint32_t>(values_at));
        values_at += e.apart();
      }
      field.resize(4);
      out.insert(out.end(), field.begin(), field.end());
    }
    append(out, std::uint32_t{0});  // no further directory
    for (const Entry& e : entries_) {
      if (e.apart() == 0) continue;
      out.insert(out.end(), e.value.begin(), e.value.end());
      out.resize(out.size() + e.apart() - e.value.size());
    }
  }

 private:
  struct Entry {
    std::uint16_t tag;
    Type type;
    std::uint32_t count;
    std::vector<std::byte> value;
    std::size_t apart() const { return value.size() > 4 ? (value.size() + 1) / 2 * 2 : 0; }
  };
  std::vector<Entry> entries_;
};

constexpr std::size_t kHeaderBytes = 8;

Directory exif(const DngPicture& p) {
  Directory out;
  out.add<std::uint32_t>(33434, kRational, 1, {p.exposure_numerator, p.exposure_denominator});
  out.add_short(34855, static_cast<std::uint16_t>(p.iso));  // PhotographicSensitivity
  return out;
}

Directory main_directory(const DngPicture& p, std::size_t exif_at, std::size_t strip_at) {
  const auto width = static_cast<std::size_t>(p.mosaic.width());
  const auto height = static_cast<std::size_t>(p.mosaic.height());
  std::vector<std::uint8_t> pattern;
  for (int i = 0; i < 4; ++i)
    pattern.push_back(static_cast<std::uint8_t>(bayer_colour(p.mosaic.pattern, i / 2, i % 2)));
  Directory out;
  out.add_long(254, 0);                   // NewSubfileType: the picture itself
  out.add_long(256, width);               // ImageWidth
  out.add_long(257, height);              // ImageLength
  out.add_short(258, 16);                 // BitsPerSample
  out.add_short(259, 1);                  // Compression: none
  out.add_short(262, 32803);              // PhotometricInterpretation: colour filter array
  out.add_text(271, p.make);              // Make
  out.add_text(272, p.model);             // Model
  out.add_long(273, strip_at);            // StripOffsets
  out.add_short(274, 1);                  // Orientation: not turned
  out.add_short(277, 1);                  // SamplesPerPixel
  out.add_long(278, height);              // RowsPerStrip
  out.add_long(279, 2 * width * height);  // StripByteCounts
  out.add_short(284, 1);                  // PlanarConfiguration
  out.add<std::uint16_t>(33421, kShort, 2, {2, 2});              // CFARepeatPatternDim
  out.add(33422, kByte, 4, pattern);                             // CFAPattern
  out.add_long(34665, exif_at);                                  // ExifIFD
  out.add<std::uint8_t>(50706, kByte, 4, {1, 4, 0, 0});          // DNGVersion
  out.add<std::uint8_t>(50707, kByte, 4, {1, 1, 0, 0});          // DNGBackwardVersion
  out.add_text(50708, p.make + " " + p.model);                   // UniqueCameraModel
  out.add_short(50714, static_cast<std::uint16_t>(p.black_dn));  // BlackLevel
  out.add_short(50717, static_cast<std::uint16_t>(p.white_dn));  // WhiteLevel
  // The camera's colours are taken for XYZ: a profile says more than one matrix could.
  out.add<std::int32_t>(50721, kSignedRational, 9,  // ColorMatrix1
                        {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
  out.add<std::uint32_t>(50728, kRational, 3, {1, 1, 1, 1, 1, 1});  // AsShotNeutral
  out.add_text(50735, p.serial);                                    // CameraSerialNumber
  out.add_short(50778, 21);                                         // CalibrationIlluminant1: D65
  return out;
}

}  // namespace

std::vector<std::byte> dng_file(const DngPicture& p) {
  const Directory exposure = exif(p);
  const std::size_t exif_at = kHeaderBytes + main_directory(p, 0, 0).size();
  const std::size_t strip_at = exif_at + exposure.size();
  std::vector<std::byte> out;
  out.reserve(strip_at + 2 * p.mosaic.dn.total());
  append(out, std::uint16_t{0x4949});  // little-endian
  append(out, std::uint16_t{42});
  append(out, static_cast<std::uint32_t>(kHeaderBytes));
  main_directory(p, exif_at, strip_at).write(out, kHeaderBytes);
  exposure.write(out, exif_at);
  for (int r = 0; r < p.mosaic.height(); ++r) {
    const auto* row = reinterpret_cast<const std::byte*>(p.mosaic.dn[r]);
    out.insert(out.end(), row, row + 2 * static_cast<std::size_t>(p.mosaic.width()));
  }
  return out;
}

}  // namespace wheatstone
