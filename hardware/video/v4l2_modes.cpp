#include "hardware/video/v4l2_modes.h"

#include <linux/videodev2.h>

#include <utility>

#include "hardware/video/pixel_formats.h"
#include "hardware/video/v4l2_list.h"

namespace wheatstone {
namespace {

constexpr std::uint32_t kLongestList = 256;

// Calls use(entry) for each entry of one of the camera's lists, till use() says that it is over.
template <class Entry, class Use>
void enumerate(V4l2Node& node, unsigned long request, Entry entry, const Deadline& deadline,
               const Use& use) {
  for (entry.index = 0; entry.index < kLongestList; ++entry.index) {
    node.check(deadline);
    Entry answer = entry;
    if (node.ask(request, &answer, "list its modes") != 0) return;
    if (!use(answer)) return;
  }
  throw DeviceError(DeviceError::Kind::kProtocol, node.what() + " lists modes without end",
                    "update its kernel driver");
}

using Size = std::pair<std::uint32_t, std::uint32_t>;

std::vector<Size> sizes(V4l2Node& node, std::uint32_t format, const Deadline& deadline) {
  std::vector<Size> out;
  v4l2_frmsizeenum about{};
  about.pixel_format = format;
  enumerate(node, VIDIOC_ENUM_FRAMESIZES, about, deadline, [&](const v4l2_frmsizeenum& s) {
    if (s.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      out.emplace_back(s.discrete.width, s.discrete.height);
      return true;
    }
    out = {{s.stepwise.min_width, s.stepwise.min_height},
           {s.stepwise.max_width, s.stepwise.max_height}};
    return false;
  });
  return out;
}

double rate(const v4l2_fract& period) {
  return period.numerator ? static_cast<double>(period.denominator) / period.numerator : 0;
}

// At least one; 0: the camera does not say.
std::vector<double> rates(V4l2Node& node, std::uint32_t format, const Size& size,
                          const Deadline& deadline) {
  std::vector<double> out;
  v4l2_frmivalenum about{};
  about.pixel_format = format;
  about.width = size.first;
  about.height = size.second;
  enumerate(node, VIDIOC_ENUM_FRAMEINTERVALS, about, deadline, [&](const v4l2_frmivalenum& i) {
    if (i.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      out.push_back(rate(i.discrete));
      return true;
    }
    out = {rate(i.stepwise.min), rate(i.stepwise.max)};
    return false;
  });
  if (out.empty()) out.push_back(0);
  return out;
}

}  // namespace

std::vector<VideoMode> list_modes(V4l2Node& node, const Deadline& deadline) {
  std::vector<VideoMode> out;
  v4l2_fmtdesc about{};
  about.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  enumerate(node, VIDIOC_ENUM_FMT, about, deadline, [&](const v4l2_fmtdesc& format) {
    const std::string name = fourcc_name(format.pixelformat);
    if (!is_known_format(name)) return true;
    for (const Size& size : sizes(node, format.pixelformat, deadline))
      for (const double r : rates(node, format.pixelformat, size, deadline))
        out.push_back({name, static_cast<int>(size.first), static_cast<int>(size.second), r});
    return true;
  });
  return out;
}

}  // namespace wheatstone
