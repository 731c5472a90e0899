#include "tests/contract/outputs/x_server.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xcb/randr.h>

#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace wheatstone {
namespace {

/// A short visit of another program.
class Visitor {
 public:
  explicit Visitor(const std::string& display) : c_(xcb_connect(display.c_str(), nullptr)) {
    if (xcb_connection_has_error(c_)) throw std::runtime_error("no X server");
    const xcb_window_t root = xcb_setup_roots_iterator(xcb_get_setup(c_)).data->root;
    const auto resources = own(xcb_randr_get_screen_resources_current_reply(
        c_, xcb_randr_get_screen_resources_current(c_, root), nullptr));
    output = *xcb_randr_get_screen_resources_current_outputs(resources.get());
    crtc = *xcb_randr_get_screen_resources_current_crtcs(resources.get());
  }
  ~Visitor() {
    std::free(xcb_get_input_focus_reply(c_, xcb_get_input_focus(c_), nullptr));  // all is done
    xcb_disconnect(c_);
  }
  Visitor(const Visitor&) = delete;
  Visitor& operator=(const Visitor&) = delete;

  template <class T>
  static std::unique_ptr<T, decltype(&std::free)> own(T* reply) {
    return {reply, &std::free};
  }
  xcb_connection_t* get() const { return c_; }
  xcb_atom_t atom(const std::string& name) const {
    return own(xcb_intern_atom_reply(
                   c_, xcb_intern_atom(c_, 0, static_cast<std::uint16_t>(name.size()), name.data()),
                   nullptr))
        ->atom;
  }
  void change(const std::string& property, xcb_atom_t type, std::uint8_t bits_each,
              std::uint32_t count, const void* values) const {
    xcb_randr_change_output_property(c_, output, atom(property), type, bits_each,
                                     XCB_PROP_MODE_REPLACE, count, values);
  }

  xcb_randr_output_t output = 0;
  xcb_randr_crtc_t crtc = 0;

 private:
  xcb_connection_t* c_;
};

}  // namespace

XServer::XServer(const std::vector<std::string>& options) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  std::vector<std::string> command = {WHEATSTONE_XVFB, "-displayfd", "3",   "-screen", "0",
                                      "640x480x24",    "-nolisten",  "tcp", "-noreset"};
  command.insert(command.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDWR, 0);
  posix_spawn_file_actions_adddup2(&actions, 0, 1);
  posix_spawn_file_actions_adddup2(&actions, 0, 2);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 3);
  posix_spawn_file_actions_addclosefrom_np(&actions, 4);
  const int error =
      ::posix_spawn(&process_, WHEATSTONE_XVFB, &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  std::string number;
  char c = 0;
  while (error == 0 && ::read(ends[0], &c, 1) == 1 && c != '\n') number += c;
  ::close(ends[0]);
  if (number.empty()) throw std::runtime_error("Xvfb does not start");
  display_ = ":" + number;
}

XServer::~XServer() {
  thaw();
  kill();
}

void XServer::freeze() {
  ::kill(process_, SIGSTOP);
}

void XServer::thaw() {
  if (process_ > 0) ::kill(process_, SIGCONT);
}

void XServer::kill() {
  if (process_ <= 0) return;
  ::kill(process_, SIGTERM);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

void XServer::set_edid(std::span<const std::byte> edid) {
  const Visitor v(display_);
  v.change("EDID", XCB_ATOM_INTEGER, 8, static_cast<std::uint32_t>(edid.size()), edid.data());
}

void XServer::set_choice(const std::string& property, const std::string& value) {
  const Visitor v(display_);
  const xcb_atom_t atom = v.atom(value);
  v.change(property, XCB_ATOM_ATOM, 32, 1, &atom);
}

void XServer::set_integers(const std::string& property, const std::vector<std::uint32_t>& values) {
  const Visitor v(display_);
  v.change(property, XCB_ATOM_INTEGER, 32, static_cast<std::uint32_t>(values.size()),
           values.data());
}

void XServer::set_gamma(const std::vector<std::uint16_t>& table) {
  const Visitor v(display_);
  xcb_randr_set_crtc_gamma(v.get(), v.crtc, static_cast<std::uint16_t>(table.size()), table.data(),
                           table.data(), table.data());
}

std::vector<std::uint16_t> XServer::gamma() const {
  const Visitor v(display_);
  const auto reply = Visitor::own(
      xcb_randr_get_crtc_gamma_reply(v.get(), xcb_randr_get_crtc_gamma(v.get(), v.crtc), nullptr));
  const std::uint16_t* red = xcb_randr_get_crtc_gamma_red(reply.get());
  return {red, red + reply->size};
}

}  // namespace wheatstone
