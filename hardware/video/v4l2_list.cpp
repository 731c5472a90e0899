#include "hardware/video/v4l2_list.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "hardware/device_error.h"
#include "hardware/transport/transcript.h"
#include "hardware/video/v4l2_camera.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

constexpr const char* kClass = "/sys/class/video4linux";

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return printable(line);
}

bool captures(const v4l2_capability& about) {
  const std::uint32_t can =
      about.capabilities & V4L2_CAP_DEVICE_CAPS ? about.device_caps : about.capabilities;
  return can & V4L2_CAP_VIDEO_CAPTURE;
}

// False: captures nothing.
bool look_at(VideoCameraFound& camera) {
  const int handle = ::open(camera.node.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (handle < 0) {
    camera.trouble = std::strerror(errno);
    return errno != ENOENT;
  }
  v4l2_capability about{};
  bool camera_like = true;
  if (::ioctl(handle, VIDIOC_QUERYCAP, &about) != 0)
    camera.trouble = std::strerror(errno);
  else
    camera_like = captures(about);
  if (camera.trouble.empty() && ::flock(handle, LOCK_EX | LOCK_NB) != 0)
    camera.trouble = "in use by another program";
  ::close(handle);
  return camera_like;
}

}  // namespace

std::uint32_t fourcc(const std::string& name) {
  return v4l2_fourcc(static_cast<unsigned char>(name[0]), static_cast<unsigned char>(name[1]),
                     static_cast<unsigned char>(name[2]), static_cast<unsigned char>(name[3]));
}

std::string fourcc_name(std::uint32_t code) {
  std::string name(4, ' ');
  for (unsigned i = 0; i < 4; ++i) name[i] = static_cast<char>(code >> (8 * i) & 0xff);
  return name;
}

std::string usb_serial_of(const fs::path& node) {
  std::error_code none;
  const fs::path real = fs::canonical(node, none);
  // The node belongs to an interface of the USB device that has the serial.
  const fs::path interface =
      fs::canonical(fs::path(kClass) / (none ? node : real).filename() / "device", none);
  return none ? "" : first_line(interface.parent_path() / "serial");
}

std::vector<VideoCameraFound> list_video_cameras() {
  std::vector<VideoCameraFound> out;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(kClass, none)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("video")) continue;
    VideoCameraFound camera{fs::path("/dev") / name, first_line(entry.path() / "name"),
                            usb_serial_of(name), ""};
    if (look_at(camera)) out.push_back(std::move(camera));
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    const std::string& m = a.node.native();
    const std::string& n = b.node.native();
    return std::pair(m.size(), m) < std::pair(n.size(), n);
  });
  return out;
}

fs::path find_video_node(const std::string& usb_serial) {
  std::vector<fs::path> found;
  for (const VideoCameraFound& camera : list_video_cameras())
    if (camera.usb_serial == usb_serial) found.push_back(camera.node);
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw DeviceError(DeviceError::Kind::kNotFound,
                      fmt::format("no video camera has the USB serial '{}'", usb_serial),
                      "plug it in, or correct its serial in the rig file");
  throw DeviceError(DeviceError::Kind::kNotFound,
                    fmt::format("{} and {} both have the USB serial '{}'", found[0].string(),
                                found[1].string(), usb_serial),
                    "name one by its link in /dev/v4l/by-path");
}

}  // namespace wheatstone
