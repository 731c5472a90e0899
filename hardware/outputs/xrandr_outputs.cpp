#include "hardware/outputs/xrandr_outputs.h"

#include <fmt/format.h>
#include <poll.h>
#include <xcb/randr.h>
#include <xcb/xcbext.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <map>
#include <span>
#include <string_view>

#include "hardware/edid.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000;
constexpr xcb_render_fixed_t kOne = 1 << 16;

template <class Reply>
using Owned = std::unique_ptr<Reply, decltype(&std::free)>;

double refresh_hz(const xcb_randr_mode_info_t& mode) {
  double lines = static_cast<double>(mode.htotal) * mode.vtotal;
  if (mode.mode_flags & XCB_RANDR_MODE_FLAG_DOUBLE_SCAN) lines *= 2;
  if (mode.mode_flags & XCB_RANDR_MODE_FLAG_INTERLACE) lines /= 2;
  return lines > 0 ? mode.dot_clock / lines : 0;
}

bool is_identity(const xcb_render_transform_t& m) {
  return m.matrix11 == kOne && m.matrix22 == kOne && m.matrix33 == kOne && m.matrix12 == 0 &&
         m.matrix13 == 0 && m.matrix21 == 0 && m.matrix23 == 0 && m.matrix31 == 0 &&
         m.matrix32 == 0;
}

/// A matrix of 3x3 fixed-point numbers, whole parts in the high words; all 0 where none was set.
bool is_other_matrix(const std::vector<std::byte>& value) {
  std::array<std::uint32_t, 18> words{};
  if (value.size() != sizeof words) return false;
  std::memcpy(words.data(), value.data(), sizeof words);
  std::array<std::uint32_t, 18> identity{};
  identity[1] = identity[9] = identity[17] = 1;
  return words != identity && words != std::array<std::uint32_t, 18>{};
}

}  // namespace

/// The connection. After an error of a request it is as good as before; after a lost connection all
/// calls throw kDisconnected.
class XrandrOutputs::Server {
 public:
  explicit Server(const std::string& display)
      : what_("the X server" + (display.empty() ? "" : " " + display)) {
    int screen = 0;
    connection_ = xcb_connect(display.empty() ? nullptr : display.c_str(), &screen);
    if (xcb_connection_has_error(connection_)) {
      xcb_disconnect(connection_);
      throw DeviceError(Kind::kNotFound, what_ + " does not answer",
                        "start it, or set DISPLAY and its access rights (xhost)");
    }
    xcb_screen_iterator_t screens = xcb_setup_roots_iterator(xcb_get_setup(connection_));
    for (; screen > 0 && screens.rem > 1; --screen) xcb_screen_next(&screens);
    root_ = screens.data->root;
    depth_ = screens.data->root_depth;
  }
  ~Server() { xcb_disconnect(connection_); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const std::string& what() const { return what_; }
  xcb_connection_t* connection() const { return connection_; }
  xcb_window_t root() const { return root_; }
  int bits_per_channel() const { return depth_ / 3; }  // 24: 8, 30: 10

  std::string vendor() const {
    const xcb_setup_t* setup = xcb_get_setup(connection_);
    return {xcb_setup_vendor(setup), static_cast<std::size_t>(xcb_setup_vendor_length(setup))};
  }
  std::string release() const { return std::to_string(xcb_get_setup(connection_)->release_number); }

  /// The reply to a request just made.
  template <class Reply, class Cookie>
  Owned<Reply> reply(Cookie cookie, const Deadline& deadline) {
    return {static_cast<Reply*>(wait(cookie.sequence, deadline)), &std::free};
  }

  xcb_atom_t atom(std::string_view name, const Deadline& deadline) {
    const auto reply_ = reply<xcb_intern_atom_reply_t>(
        xcb_intern_atom(connection_, 0, static_cast<std::uint16_t>(name.size()), name.data()),
        deadline);
    return reply_->atom;
  }
  /// Of a property that is one of several names; empty: it has none.
  std::string choice(xcb_randr_output_t output, const char* property_name,
                     const Deadline& deadline) {
    const std::vector<std::byte> value = property(output, property_name, deadline);
    xcb_atom_t atom = XCB_ATOM_NONE;
    if (value.size() == sizeof atom) std::memcpy(&atom, value.data(), sizeof atom);
    if (atom == XCB_ATOM_NONE) return "";
    const auto name =
        reply<xcb_get_atom_name_reply_t>(xcb_get_atom_name(connection_, atom), deadline);
    return {xcb_get_atom_name_name(name.get()),
            static_cast<std::size_t>(xcb_get_atom_name_name_length(name.get()))};
  }
  /// 0: it has none.
  int integer(xcb_randr_output_t output, const char* property_name, const Deadline& deadline) {
    const std::vector<std::byte> value = property(output, property_name, deadline);
    std::int32_t out = 0;
    if (value.size() == sizeof out) std::memcpy(&out, value.data(), sizeof out);
    return out;
  }
  /// Empty: it has none.
  std::vector<std::byte> property(xcb_randr_output_t output, const char* name,
                                  const Deadline& deadline) {
    constexpr std::uint32_t kMostWords = 256;
    const auto value = reply<xcb_randr_get_output_property_reply_t>(
        xcb_randr_get_output_property(connection_, output, atom(name, deadline), XCB_ATOM_NONE, 0,
                                      kMostWords, 0, 0),
        deadline);
    const auto* bytes =
        reinterpret_cast<const std::byte*>(xcb_randr_get_output_property_data(value.get()));
    return {bytes, bytes + xcb_randr_get_output_property_data_length(value.get())};
  }

 private:
  void* wait(unsigned sequence, const Deadline& deadline) {
    const SteadyClock clock;
    xcb_flush(connection_);
    for (;;) {
      void* reply = nullptr;
      xcb_generic_error_t* error = nullptr;
      const int done = xcb_poll_for_reply(connection_, sequence, &reply, &error);
      if (xcb_connection_has_error(connection_)) {
        std::free(reply);
        std::free(error);
        throw DeviceError(Kind::kDisconnected, what_ + " has gone",
                          "start it again, then run the command again");
      }
      if (done && reply) return reply;
      if (done) {
        const int code = error ? error->error_code : 0;
        std::free(error);
        throw DeviceError(Kind::kRefused, fmt::format("{} answers with error {}", what_, code),
                          "check that no other program changes the displays");
      }
      const Nanoseconds left = deadline.at_ns - clock.now_ns();
      if (left <= 0 || deadline.cancel.stop_requested()) {
        xcb_discard_reply(connection_, sequence);
        if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
        throw DeviceError(Kind::kTimeout, what_ + " did not answer in time",
                          "check that it is alive, then run the command again");
      }
      const timespec slice{0, static_cast<long>(std::min(left, kStopCheckNs))};
      pollfd line{xcb_get_file_descriptor(connection_), POLLIN, 0};
      ::ppoll(&line, 1, &slice, nullptr);
    }
  }

  std::string what_;
  xcb_connection_t* connection_ = nullptr;
  xcb_window_t root_ = 0;
  int depth_ = 0;
};

XrandrOutputs::XrandrOutputs(const XrandrSettings& settings, const Deadline& deadline)
    : settings_(settings), server_(std::make_unique<Server>(settings.display)) {
  xcb_connection_t* c = server_->connection();
  const auto extension =
      server_->reply<xcb_query_extension_reply_t>(xcb_query_extension(c, 5, "RANDR"), deadline);
  if (extension->present) {
    const auto version =
        server_->reply<xcb_randr_query_version_reply_t>(xcb_randr_query_version(c, 1, 3), deadline);
    identity_ = {"xrandr", server_->vendor(), "", server_->release(), server_->what()};
    if (version->major_version > 1 || version->minor_version >= 3) return;
  }
  throw DeviceError(Kind::kRefused, server_->what() + " has no RandR 1.3", "use a newer one");
}

XrandrOutputs::~XrandrOutputs() {
  try {
    const Deadline soon = SteadyClock().in(settings_.restoring);
    for (const Table& table : found_) write_table(table, soon);
  } catch (const Error&) {  // it has gone, and its tables with it
  }
}

std::vector<DisplayOutput> XrandrOutputs::enumerate(Deadline deadline) {
  Server& s = *server_;
  xcb_connection_t* c = s.connection();
  const auto resources = s.reply<xcb_randr_get_screen_resources_current_reply_t>(
      xcb_randr_get_screen_resources_current(c, s.root()), deadline);
  std::map<xcb_randr_mode_t, xcb_randr_mode_info_t> modes;
  for (auto it = xcb_randr_get_screen_resources_current_modes_iterator(resources.get()); it.rem;
       xcb_randr_mode_info_next(&it))
    modes[it.data->id] = *it.data;
  const xcb_randr_output_t* ids = xcb_randr_get_screen_resources_current_outputs(resources.get());
  std::vector<DisplayOutput> out;
  for (int i = 0; i < resources->num_outputs; ++i) {
    const auto info = s.reply<xcb_randr_get_output_info_reply_t>(
        xcb_randr_get_output_info(c, ids[i], resources->config_timestamp), deadline);
    if (info->connection != XCB_RANDR_CONNECTION_CONNECTED) continue;
    DisplayOutput output;
    output.connector.assign(
        reinterpret_cast<const char*>(xcb_randr_get_output_info_name(info.get())), info->name_len);
    output.edid = parse_edid(s.property(ids[i], "EDID", deadline)).value_or(EdidIdentity{});
    output.bits_per_channel = s.bits_per_channel();
    // Video drivers name it one way or the other.
    output.dithering = s.choice(ids[i], "dithering mode", deadline);
    if (output.dithering.empty()) output.dithering = s.choice(ids[i], "dither", deadline);
    output.range = s.choice(ids[i], "Broadcast RGB", deadline);
    output.link_bits_per_channel = s.integer(ids[i], "max bpc", deadline);
    output.has_colour_matrix = is_other_matrix(s.property(ids[i], "CTM", deadline));
    if (info->crtc != XCB_NONE) {
      const auto crtc = s.reply<xcb_randr_get_crtc_info_reply_t>(
          xcb_randr_get_crtc_info(c, info->crtc, resources->config_timestamp), deadline);
      output.x_px = crtc->x;
      output.y_px = crtc->y;
      output.width_px = crtc->width;
      output.height_px = crtc->height;
      if (const auto mode = modes.find(crtc->mode); mode != modes.end())
        output.refresh_hz = refresh_hz(mode->second);
      const Table table = read_table(info->crtc, deadline);
      output.gamma_size = static_cast<int>(table.red.size());
      output.gamma_is_identity = is_identity_gamma(table.red) && is_identity_gamma(table.green) &&
                                 is_identity_gamma(table.blue);
      const auto transform = s.reply<xcb_randr_get_crtc_transform_reply_t>(
          xcb_randr_get_crtc_transform(c, info->crtc), deadline);
      const auto border = s.property(ids[i], "Border", deadline);
      // At the panel's own mode there is nothing to scale.
      const xcb_randr_mode_t* own = xcb_randr_get_output_info_modes(info.get());
      const bool native =
          std::find(own, own + info->num_preferred, crtc->mode) != own + info->num_preferred;
      const std::string scaling = s.choice(ids[i], "scaling mode", deadline);
      output.is_scaled =
          !is_identity(transform->current_transform) ||
          crtc->rotation != XCB_RANDR_ROTATION_ROTATE_0 ||
          (!native && !scaling.empty() && scaling != "None") ||
          s.choice(ids[i], "underscan", deadline) == "on" ||
          std::any_of(border.begin(), border.end(), [](std::byte b) { return b != std::byte{0}; });
    }
    out.push_back(std::move(output));
  }
  return out;
}

XrandrOutputs::Table XrandrOutputs::read_table(std::uint32_t crtc, const Deadline& deadline) {
  const auto gamma = server_->reply<xcb_randr_get_crtc_gamma_reply_t>(
      xcb_randr_get_crtc_gamma(server_->connection(), crtc), deadline);
  const auto copy = [&](const std::uint16_t* from) {
    return std::vector<std::uint16_t>(from, from + gamma->size);
  };
  return {crtc, copy(xcb_randr_get_crtc_gamma_red(gamma.get())),
          copy(xcb_randr_get_crtc_gamma_green(gamma.get())),
          copy(xcb_randr_get_crtc_gamma_blue(gamma.get()))};
}

void XrandrOutputs::write_table(const Table& table, const Deadline& deadline) {
  xcb_randr_set_crtc_gamma(server_->connection(), table.crtc,
                           static_cast<std::uint16_t>(table.red.size()), table.red.data(),
                           table.green.data(), table.blue.data());
  read_table(table.crtc, deadline);  // it has been done when this is answered
}

void XrandrOutputs::neutralise(Deadline deadline) {
  const auto resources = server_->reply<xcb_randr_get_screen_resources_current_reply_t>(
      xcb_randr_get_screen_resources_current(server_->connection(), server_->root()), deadline);
  const xcb_randr_crtc_t* crtcs = xcb_randr_get_screen_resources_current_crtcs(resources.get());
  for (int i = 0; i < resources->num_crtcs; ++i) {
    Table table = read_table(crtcs[i], deadline);
    if (table.red.size() < 2) continue;  // a controller without one
    if (std::none_of(found_.begin(), found_.end(),
                     [&](const Table& t) { return t.crtc == table.crtc; }))
      found_.push_back(table);
    for (std::size_t k = 0; k < table.red.size(); ++k)
      table.red[k] = table.green[k] = table.blue[k] =
          static_cast<std::uint16_t>(identity_gamma(k, table.red.size()));
    write_table(table, deadline);
    const Table now = read_table(table.crtc, deadline);
    if (!is_identity_gamma(now.red) || !is_identity_gamma(now.green) ||
        !is_identity_gamma(now.blue))
      throw DeviceError(Kind::kFault,
                        fmt::format("a gamma table of {} stays as it was", server_->what()),
                        "end what sets it (night light, colour management)");
  }
}

}  // namespace wheatstone
