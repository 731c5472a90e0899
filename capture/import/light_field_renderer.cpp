#include "capture/import/light_field_renderer.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include "core/error.h"

namespace wheatstone {

std::vector<ImportedView> read_light_field_folder(const std::filesystem::path& folder) {
  static const std::regex kName(
      R"(.+_\d+_\d+_(-?[0-9.]+)_(-?[0-9.]+)_([0-9.]+)_([0-9.]+)\.(jpg|jpeg|png))",
      std::regex::icase);
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator it(folder, error);
  for (; !error && it != std::filesystem::directory_iterator(); it.increment(error))
    files.push_back(it->path());
  if (error)
    throw FileError(folder, "cannot be listed: " + error.message(), "give a folder of pictures");
  std::sort(files.begin(), files.end());

  std::vector<ImportedView> views;
  for (const auto& file : files) {
    const std::string name = file.filename().string();
    std::smatch part;
    if (name.size() > 255 || !std::regex_match(name, part, kName)) continue;
    double number[4];
    for (int i = 0; i < 4; ++i) {
      const std::string text = part[i + 1];
      std::size_t used = 0;
      try {
        number[i] = std::stod(text, &used);
      } catch (const std::exception&) {
        used = 0;
      }
      if (used != text.size() || (i >= 2 && !(number[i] > 0)))
        throw FileError(file, "'" + text + "' in the name is not a possible length in mm",
                        "name it <scene>_<row>_<col>_<-y mm>_<x mm>_<focal mm>_<sensor mm>");
    }
    const auto [minus_y_mm, x_mm, focal_mm, sensor_mm] = number;
    const cv::Size size = picture_size(file);
    const double f_px = focal_mm / sensor_mm * size.width;
    ImportedView view;
    view.name = file.stem().string();
    view.path = file;
    view.intrinsics = {f_px,       f_px,       0, 0.5 * (size.width - 1), 0.5 * (size.height - 1),
                       size.width, size.height};
    view.T_camera_world.R = Eigen::Vector3d(1, -1, -1).asDiagonal();
    view.T_camera_world.t_mm = -(view.T_camera_world.R * Eigen::Vector3d(x_mm, -minus_y_mm, 0));
    views.push_back(std::move(view));
  }
  if (views.empty())
    throw FileError(folder, "holds no picture with a camera position in its name",
                    "name them <scene>_<row>_<col>_<-y mm>_<x mm>_<focal mm>_<sensor mm>.jpg");
  return views;
}

}  // namespace wheatstone
