#include "core/png.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {

namespace {

std::vector<unsigned char> encode(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1}))
    throw InternalError("a picture could not be encoded as PNG");
  return bytes;
}

void write(const std::filesystem::path& path, const cv::Mat& image) {
  const std::vector<unsigned char> bytes = encode(image);
  write_bytes_atomically(path, std::as_bytes(std::span(bytes)));
}

/// True for a JPEG that ends before its end marker. The decoder would fill the rest with grey.
bool is_truncated_jpeg(std::span<const std::byte> bytes) {
  const std::string_view file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!file.starts_with("\xff\xd8")) return false;
  const auto scan = file.rfind("\xff\xda"), end = file.rfind("\xff\xd9");
  return end == std::string_view::npos || scan == std::string_view::npos || end < scan;
}

cv::Mat read(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  if (is_truncated_jpeg(bytes))
    throw FileError(path, "is damaged: the JPEG ends early", "copy or export the picture again");
  cv::Mat image;
  try {
    image = cv::imdecode(
        cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<std::byte*>(bytes.data())),
        cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty())
    throw FileError(path, "is damaged or not a picture this program reads",
                    "give a PNG, JPEG or TIFF file");
  return image;
}

cv::Mat swap_red_blue(const cv::Mat& image) {
  cv::Mat swapped;
  cv::cvtColor(image, swapped, cv::COLOR_BGR2RGB);
  return swapped;
}

double srgb_to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double linear_to_srgb(double v) {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

}  // namespace

void write_mosaic_png(const std::filesystem::path& path, const MosaicImage& mosaic) {
  write(path, mosaic.dn);
}

MosaicImage read_mosaic_png(const std::filesystem::path& path, BayerPattern pattern) {
  const cv::Mat image = read(path);
  if (image.type() != CV_16UC1)
    throw FileError(path, "is not a 16-bit single-channel raw frame", "capture it again");
  return {cv::Mat1w(image), pattern};
}

void write_drive_png(const std::filesystem::path& path, const DriveImage& drive) {
  WHEATSTONE_CHECK(drive.codes.depth(), ==, CV_8U);
  write(path, drive.codes.channels() == 3 ? swap_red_blue(drive.codes) : drive.codes);
}

DriveImage read_drive_png(const std::filesystem::path& path) {
  const cv::Mat image = read(path);
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3)
    throw FileError(path, "is not an 8-bit drive image with one or three channels",
                    "run `wheatstone present` again");
  return {image.channels() == 3 ? swap_red_blue(image) : image};
}

cv::Mat3b to_srgb8(const RgbImage& image, double white_cd_m2) {
  cv::Mat3b out(image.height(), image.width());
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c)
      for (int k = 0; k < 3; ++k) {
        const double v = std::clamp(image.pixels(r, c)[k] / white_cd_m2, 0.0, 1.0);
        out(r, c)[k] = static_cast<unsigned char>(std::lround(255 * linear_to_srgb(v)));
      }
  return out;
}

void write_picture_png(const std::filesystem::path& path, const cv::Mat3b& rgb) {
  write(path, swap_red_blue(rgb));
}

std::vector<unsigned char> encode_picture_png(const cv::Mat3b& rgb) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", swap_red_blue(rgb), bytes))
    throw InternalError("a picture could not be encoded as PNG");
  return bytes;
}

cv::Mat1b read_grey_picture(const std::filesystem::path& path) {
  cv::Mat image = read(path);
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / 257);
  if (image.depth() != CV_8U)
    throw FileError(path, "is not an 8- or 16-bit grey or colour picture", "convert it");
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2GRAY);
  return image;
}

RgbImage read_encoded_picture(const std::filesystem::path& path,
                              const std::function<double(double)>& light_cd_m2) {
  const cv::Mat image = read(path);
  const int depth = image.depth(), channels = image.channels();
  if ((depth != CV_8U && depth != CV_16U) || (channels != 1 && channels != 3 && channels != 4))
    throw FileError(path, "is not an 8- or 16-bit grey or colour picture", "convert it");
  const int top = depth == CV_8U ? 255 : 65535;
  std::vector<float> table(static_cast<std::size_t>(top) + 1);
  for (int i = 0; i <= top; ++i)
    table[i] = static_cast<float>(light_cd_m2(static_cast<double>(i) / top));
  RgbImage out(image.cols, image.rows);
  for (int r = 0; r < image.rows; ++r)
    for (int c = 0; c < image.cols; ++c)
      for (int k = 0; k < 3; ++k) {
        const int channel = channels == 1 ? 0 : 2 - k;
        const int at = c * channels + channel;
        const int code =
            depth == CV_8U ? image.ptr<unsigned char>(r)[at] : image.ptr<unsigned short>(r)[at];
        out.pixels(r, c)[k] = table[code];
      }
  return out;
}

RgbImage read_srgb_picture(const std::filesystem::path& path, double white_cd_m2) {
  if (!(white_cd_m2 > 0) || !std::isfinite(white_cd_m2))
    throw ArgumentError("the luminance of full white must be positive",
                        "state it, for example --white-cd-m2 100");
  return read_encoded_picture(path, [&](double v) { return white_cd_m2 * srgb_to_linear(v); });
}

}  // namespace wheatstone
