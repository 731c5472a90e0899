#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiView.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>

#include "core/exr.h"
#include "core/exr_file.h"

namespace wheatstone {
namespace {

ExrView& view_named(std::vector<ExrView>& views, const std::string& name) {
  const auto found = std::find_if(views.begin(), views.end(),
                                  [&](const ExrView& view) { return view.name == name; });
  if (found != views.end()) return *found;
  views.emplace_back().name = name;
  return views.back();
}

bool has_prefixes(const Imf::Header& header) {
  return Imf::hasMultiView(header) && !Imf::multiView(header).empty();
}

/// The views that a part's channel names may refer to, the default first; empty if the part names
/// none.
Imf::StringVector views_of(const Imf::Header& header) {
  if (has_prefixes(header)) return Imf::multiView(header);
  if (header.hasView()) return {header.view()};
  return {};
}

}  // namespace

std::vector<ExrView> read_exr_views(const std::filesystem::path& path) {
  return detail::with_file_errors(path, [&] {
    const auto file = detail::open_exr(path);
    // Parts without a view, such as disparity maps between two views, belong to the first one.
    std::string first_view;
    for (int part = 0; part < file->parts() && first_view.empty(); ++part)
      if (const Imf::StringVector own = views_of(file->header(part)); !own.empty())
        first_view = own.front();
    std::vector<ExrView> views;
    for (int part = 0; part < file->parts(); ++part) {
      const Imf::Header& header = file->header(part);
      std::vector<std::string> names;
      for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        if (c.channel().type != Imf::UINT) names.emplace_back(c.name());
      if (names.empty()) continue;

      Imf::StringVector part_views = views_of(header);
      if (part_views.empty()) part_views = {first_view};
      const bool prefixed = has_prefixes(header);
      if (prefixed)
        for (const std::string& view : part_views) view_named(views, view);
      std::vector<cv::Mat1f> pixels = detail::read_channels(path, *file, part, names);
      for (std::size_t i = 0; i < names.size(); ++i) {
        std::string view_name = part_views.front(), base = names[i];
        if (prefixed) {
          // A name that mentions no view, such as "disparityL.x", belongs to the first one.
          const std::string own = Imf::viewFromChannelName(names[i], part_views);
          if (!own.empty()) view_name = own;
          base = Imf::removeViewName(names[i], view_name);
        }
        ExrView& view = view_named(views, view_name);
        view.width_px = pixels[i].cols;
        view.height_px = pixels[i].rows;
        // Parts of one view may repeat a name; the later one is told apart by its part's name.
        if (view.channels.contains(base) && header.hasName()) base = header.name() + "." + base;
        if (!view.channels.emplace(base, ScalarImage(pixels[i])).second)
          throw FileError(path, "channel '" + base + "' of view '" + view_name + "' occurs twice",
                          "give the parts different names");
      }
    }
    std::erase_if(views, [](const ExrView& view) { return view.channels.empty(); });
    if (views.empty())
      throw FileError(path, "has no channels of type half or float", "use another file");
    return views;
  });
}

}  // namespace wheatstone
