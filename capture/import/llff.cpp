#include "capture/import/llff.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kColumns = 17;
constexpr double kCentreTolerancePx = 1e-6;

[[noreturn]] void fail(const fs::path& file, const std::string& problem) {
  throw FileError(file, problem, "save it from NumPy as an N x 17 array of float64");
}

/// An array of real numbers as NumPy stores it (format versions 1.0 to 3.0), rows before columns.
struct Table {
  std::size_t rows = 0;
  std::vector<double> values;
};

std::string quoted_value(const std::string& header, const std::string& key, const fs::path& file) {
  const auto at = header.find("'" + key + "':");
  if (at == std::string::npos) fail(file, "has no " + key + " in its header");
  const auto start = header.find_first_not_of(' ', at + key.size() + 3);
  if (start == std::string::npos) fail(file, "has no " + key + " in its header");
  const char close = header[start] == '(' ? ')' : ',';
  const auto end = header.find(close, start);
  if (end == std::string::npos) fail(file, "has an unfinished header");
  return header.substr(start, end - start);
}

Table parse_npy(std::span<const std::byte> npy, const fs::path& file) {
  const std::string_view bytes(reinterpret_cast<const char*>(npy.data()), npy.size());
  if (!bytes.starts_with("\x93NUMPY") || bytes.size() < 12) fail(file, "is no .npy file");
  const auto u8 = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const bool version_1 = u8(6) == 1;
  const std::size_t start = version_1 ? 10 : 12;
  const std::size_t length =
      u8(8) + 256U * u8(9) + (version_1 ? 0U : 65536U * u8(10) + 16777216U * u8(11));
  if (u8(6) < 1 || u8(6) > 3 || length > bytes.size() - start)
    fail(file, "has a header longer than the file");
  const std::string header(bytes.substr(start, length));
  const std::string type = quoted_value(header, "descr", file);
  const std::size_t size = type == "'<f8'" ? 8 : type == "'<f4'" ? 4 : 0;
  if (size == 0) fail(file, "holds numbers of type " + type + "; '<f8' and '<f4' are read");
  if (quoted_value(header, "fortran_order", file) != "False") fail(file, "is in Fortran order");
  const std::string shape = quoted_value(header, "shape", file);
  std::size_t rows = 0, columns = 0;
  const char* const end = shape.data() + shape.size();
  const auto first = std::from_chars(shape.data() + 1, end, rows);
  if (first.ec == std::errc() && first.ptr != end) {
    const char* next = first.ptr + 1;
    while (next != end && *next == ' ') ++next;
    const auto second = std::from_chars(next, end, columns);
    if (second.ec != std::errc() || second.ptr != end) columns = 0;
  }
  const std::size_t payload = bytes.size() - start - length;
  if (columns != kColumns || rows < 1 || rows > payload / (kColumns * size))
    fail(file, "has the shape " + shape + ")");
  if (rows * kColumns * size != payload) fail(file, "does not have as many numbers as it says");
  Table table{rows, std::vector<double>(rows * kColumns)};
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    const char* const at = bytes.data() + start + length + i * size;
    if (size == 8) {
      std::memcpy(&table.values[i], at, 8);
    } else {
      float value = 0;
      std::memcpy(&value, at, 4);
      table.values[i] = value;
    }
    if (!std::isfinite(table.values[i])) fail(file, "holds a number that is not finite");
  }
  return table;
}

}  // namespace

LlffModel parse_llff(std::span<const std::byte> npy, const fs::path& file,
                     const std::vector<fs::path>& pictures, double mm_per_unit,
                     std::optional<PoseConvention> convention) {
  if (!(mm_per_unit > 0) || !std::isfinite(mm_per_unit))
    throw ArgumentError("the scale of poses must be above 0", "give mm per unit");
  const Table table = parse_npy(npy, file);
  if (!pictures.empty() && pictures.size() != table.rows)
    throw FileError(file,
                    "holds " + std::to_string(table.rows) + " poses for " +
                        std::to_string(pictures.size()) + " pictures",
                    "put exactly the posed pictures into the folder images");
  LlffModel model;
  for (std::size_t v = 0; v < table.rows; ++v) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 5, Eigen::RowMajor>> m(table.values.data() +
                                                                           v * kColumns);
    ImportedView view;
    view.name = pictures.empty() ? std::to_string(v) : pictures[v].filename().string();
    if (!pictures.empty()) view.path = pictures[v];
    const std::string which = "view " + std::to_string(v);
    const double height = m(0, 4), width = m(1, 4), f = m(2, 4);
    if (!(f > 0)) fail(file, which + " has a focal length that is not above 0");
    if (!(width >= 1 && height >= 1 && width <= 65536 && height <= 65536))
      fail(file, which + " has a picture size outside 1..65536 px");
    view.intrinsics = {f,
                       f,
                       0,
                       (width - 1) / 2,
                       (height - 1) / 2,
                       static_cast<int>(width),
                       static_cast<int>(height)};
    const Eigen::Matrix3d R = m.leftCols<3>();
    if (!(R * R.transpose()).isIdentity(1e-4) || !(R.determinant() > 0))
      fail(file, which + " holds no rotation");
    Eigen::Matrix<double, 3, 4> rigid;
    rigid << Eigen::Quaterniond(R).normalized().toRotationMatrix(), mm_per_unit * m.col(3);
    view.T_camera_world = from_stated(rigid, convention.value_or(kLlffConvention));
    model.views.push_back(view);
    model.near_mm.push_back(mm_per_unit * table.values[v * kColumns + 15]);
    model.far_mm.push_back(mm_per_unit * table.values[v * kColumns + 16]);
  }
  return model;
}

LlffModel read_llff(const fs::path& folder, double mm_per_unit,
                    std::optional<PoseConvention> convention) {
  const fs::path file = folder / "poses_bounds.npy";
  const auto npy = read_bytes(file, std::size_t{1} << 28);
  std::vector<fs::path> pictures;
  std::error_code error;
  fs::directory_iterator it(folder / "images", error);
  for (; !error && it != fs::directory_iterator(); it.increment(error))
    if (it->is_regular_file()) pictures.push_back(it->path());
  if (error || pictures.empty())
    throw FileError(folder / "images", "holds no pictures",
                    "put the posed pictures there, in the order of their names");
  std::sort(pictures.begin(), pictures.end());
  return parse_llff(npy, file, pictures, mm_per_unit, convention);
}

void write_llff(const fs::path& file, std::span<const ImportedView> views, double near_mm,
                double far_mm) {
  if (!(near_mm > 0) || !(far_mm > near_mm) || !std::isfinite(far_mm))
    throw ArgumentError("poses_bounds.npy needs the depths between which the scene lies",
                        "give --near-mm and --far-mm, 0 < near < far");
  std::vector<double> values;
  for (const ImportedView& v : views) {
    const Intrinsics& k = v.intrinsics;
    if (std::abs(k.fx_px - k.fy_px) > kCentreTolerancePx || k.skew_px != 0 ||
        std::abs(k.cx_px - (k.width_px - 1) / 2.0) > kCentreTolerancePx ||
        std::abs(k.cy_px - (k.height_px - 1) / 2.0) > kCentreTolerancePx || !v.distortion.is_zero())
      throw ArgumentError(v.name +
                              ": poses_bounds.npy holds one focal length and the principal "
                              "point in the middle, and this view is not so",
                          "export as nerf or colmap-text");
    const auto m = to_stated(v.T_camera_world, kLlffConvention);
    const double hwf[3] = {double(k.height_px), double(k.width_px), k.fx_px};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 4; ++c) values.push_back(m(r, c));
      values.push_back(hwf[r]);
    }
    values.push_back(near_mm);
    values.push_back(far_mm);
  }
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" +
                       std::to_string(views.size()) + ", 17), }";
  header.resize((10 + header.size() + 1 + 63) / 64 * 64 - 10 - 1, ' ');  // data start at 64 n
  header += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += {'\x01', '\0', static_cast<char>(header.size() % 256),
            static_cast<char>(header.size() / 256)};
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  write_bytes_atomically(file, std::as_bytes(std::span(bytes)));
}

}  // namespace wheatstone
