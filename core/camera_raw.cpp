#include "core/camera_raw.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

constexpr double kMaxPixels = 200e6;
constexpr unsigned kMaxMemory_mb = 1024;
// No raw coder packs sensor noise tighter; the free part admits small flat pictures.
constexpr double kPixelsPerFileByte = 50, kFreePixels = 4e6;
constexpr unsigned kFirstBayerCode = 1000;  // LibRaw: smaller ones are not 2x2 patterns

void require(int code, const std::filesystem::path& path) {
  if (code != LIBRAW_SUCCESS)
    throw FileError(
        path, std::string("cannot be read as a camera raw file (") + libraw_strerror(code) + ")",
        "copy it again from the camera, or give a 16-bit PNG, TIFF or PGM");
}

BayerPattern pattern_of(LibRaw& raw, const std::filesystem::path& path) {
  const libraw_iparams_t& id = raw.imgdata.idata;
  std::string name;
  if (id.filters >= kFirstBayerCode && id.colors == 3)
    for (int i = 0; i < 4; ++i) name += id.cdesc[raw.COLOR(i / 2, i % 2)];
  try {
    // The code describes eight rows; all must repeat the first two.
    for (int r = 0; r < 8 && !name.empty(); ++r)
      for (int c = 0; c < 2; ++c)
        if (id.cdesc[raw.COLOR(r, c)] != name[static_cast<std::size_t>(2 * (r % 2) + c)])
          name.clear();
    return bayer_pattern_from_string(name);
  } catch (const ArgumentError&) {
    throw FileError(path, "does not come from a sensor with a 2x2 Bayer pattern",
                    "use a camera with one");
  }
}

/// Common, per-colour and per-position black levels add up.
double black_at(LibRaw& raw, int r, int c, const std::filesystem::path& path) {
  const libraw_colordata_t& color = raw.imgdata.color;
  const unsigned rows = color.cblack[4], columns = color.cblack[5];
  double black = color.black + static_cast<double>(color.cblack[raw.COLOR(r, c)]);
  if (rows == 0 || columns == 0) return black;
  if (rows > 2 || columns > 2)
    throw FileError(path, "has a black level that repeats after more than two pixels",
                    "convert it with a uniform black level");
  return black + color.cblack[6 + static_cast<unsigned>(r) % rows * columns +
                              static_cast<unsigned>(c) % columns];
}

/// ExposureTime of the EXIF block. LibRaw takes 1 s from an empty APEX value beside it, so the
/// tag itself is asked.
struct ExifExposure {
  bool said = false;
  double seconds = 0;
};
constexpr int kExifExposureTime = 0x829a, kExifRational = 5;
constexpr unsigned kLittleEndian = 0x4949;

void note_exposure(void* context, int tag, int type, int, unsigned order, void* file, INT64) {
  if ((tag & 0xffff) != kExifExposureTime || type != kExifRational) return;
  unsigned char bytes[8] = {};
  if (static_cast<LibRaw_abstract_datastream*>(file)->read(bytes, 1, 8) != 8) return;
  const auto u32 = [&](int first) {
    unsigned value = 0;
    for (int i = 0; i < 4; ++i)
      value |= unsigned{bytes[first + i]} << (order == kLittleEndian ? 8 * i : 24 - 8 * i);
    return value;
  };
  auto& exposure = *static_cast<ExifExposure*>(context);
  exposure = {true, u32(4) > 0 ? static_cast<double>(u32(0)) / u32(4) : 0};
}

double known(float value) {
  return std::isfinite(value) && value > 0 ? static_cast<double>(value) : 0;
}

template <std::size_t N>
std::string text(const char (&field)[N]) {
  return {field, strnlen(field, N)};
}

}  // namespace

CameraRaw decode_camera_raw(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  const auto raw = std::make_unique<LibRaw>();
  raw->imgdata.params.max_raw_memory_mb = kMaxMemory_mb;
  ExifExposure exif;
  raw->set_exifparser_handler(note_exposure, &exif);
  // It only reads what it takes as changeable.
  require(raw->open_buffer(const_cast<std::byte*>(bytes.data()), bytes.size()), path);
  const libraw_image_sizes_t& sizes = raw->imgdata.sizes;
  const double pixels = static_cast<double>(sizes.raw_width) * sizes.raw_height;
  if (pixels > kMaxPixels ||
      pixels > kFreePixels + kPixelsPerFileByte * static_cast<double>(bytes.size()))
    throw FileError(path, "promises more pixels than it can hold", "copy it again from the camera");
  require(raw->unpack(), path);
  const std::uint16_t* samples = raw->imgdata.rawdata.raw_image;
  if (samples == nullptr)
    throw FileError(path, "holds a picture that is demosaiced already",
                    "give the camera's own file");
  if (sizes.width < 2 || sizes.height < 2 || sizes.left_margin + sizes.width > sizes.raw_width ||
      sizes.top_margin + sizes.height > sizes.raw_height)
    throw FileError(path, "has a visible area outside of its sensor",
                    "copy it again from the camera");

  CameraRaw out;
  out.mosaic.pattern = pattern_of(*raw, path);
  out.mosaic.dn.create(sizes.height, sizes.width);
  for (int r = 0; r < sizes.height; ++r) {
    const std::uint16_t* row =
        samples + (r + sizes.top_margin) * (sizes.raw_pitch / 2) + sizes.left_margin;
    std::copy(row, row + sizes.width, out.mosaic.dn[r]);
  }
  for (int i = 0; i < 4; ++i)
    out.black_dn[static_cast<std::size_t>(i)] = black_at(*raw, i / 2, i % 2, path);
  out.white_dn = static_cast<int>(std::min(raw->imgdata.color.maximum, 65535U));
  if (!(*std::max_element(out.black_dn.begin(), out.black_dn.end()) < out.white_dn))
    throw FileError(path, "has a white level that is not above its black level",
                    "copy it again from the camera");
  const libraw_imgother_t& other = raw->imgdata.other;
  out.exposure_s = exif.said ? exif.seconds : known(other.shutter);
  out.iso = known(other.iso_speed);
  out.f_number = known(other.aperture);
  out.camera = text(raw->imgdata.idata.make) + " " + text(raw->imgdata.idata.model);
  out.serial = text(raw->imgdata.shootinginfo.BodySerial);
  return out;
}

CameraRaw read_camera_raw(const std::filesystem::path& path) {
  return decode_camera_raw(read_bytes(path), path);
}

}  // namespace wheatstone
