#include "hardware/transport/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000;
constexpr std::size_t kMostOutput = 1'000'000;

class Handle {
 public:
  explicit Handle(int h = -1) : handle_(h) {}
  ~Handle() { close(); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  int get() const { return handle_; }
  void close() {
    if (handle_ >= 0) ::close(std::exchange(handle_, -1));
  }

 private:
  int handle_;
};

/// A process that leads a session of its own; killed with all its group at the end.
class Child {
 public:
  Child(const std::string& what, const std::vector<std::string>& command, int output) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, output, 1);
    posix_spawn_file_actions_adddup2(&actions, output, 2);
    posix_spawn_file_actions_addclosefrom_np(&actions, 3);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const int error =
        ::posix_spawnp(&process_, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (error != 0)
      throw DeviceError(error == EACCES ? Kind::kPermission : Kind::kNotFound,
                        fmt::format("{} cannot be started ({})", what, std::strerror(error)),
                        "install it, or correct its path");
  }
  ~Child() {
    ::kill(-process_, SIGKILL);
    if (!ended_) wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t process() const { return process_; }
  int wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t process_ = -1;
  bool ended_ = false;
};

/// False: there is no more.
bool read_some(int from, std::string& output) {
  char buffer[4096];
  const ssize_t n = ::read(from, buffer, sizeof buffer);
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  output.append(buffer, static_cast<std::size_t>(n));
  return n > 0;
}

}  // namespace

ChildResult run_child(const std::string& what, const std::vector<std::string>& command,
                      const Deadline& deadline) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0)
    throw DeviceError(Kind::kFault, fmt::format("{}: {}", what, std::strerror(errno)),
                      "close other programs");
  const Handle from(ends[0]);
  Handle to(ends[1]);
  ::fcntl(to.get(), F_SETFL, 0);  // the program expects to wait
  Child child(what, command, to.get());
  to.close();
  const Handle ended(static_cast<int>(::syscall(SYS_pidfd_open, child.process(), 0)));
  ChildResult result;
  const SteadyClock clock;
  for (bool open = true;;) {
    if (deadline.cancel.stop_requested()) throw Cancelled(what + ": stopped on request");
    const Nanoseconds left = deadline.at_ns - clock.now_ns();
    if (left <= 0)
      throw DeviceError(Kind::kTimeout, what + " did not end in time and was killed",
                        "check the device's cable, or allow more time");
    const timespec slice{0, static_cast<long>(std::min(left, kStopCheckNs))};
    pollfd handles[2] = {{open ? from.get() : -1, POLLIN, 0}, {ended.get(), POLLIN, 0}};
    if (::ppoll(handles, 2, &slice, nullptr) <= 0) continue;
    if (handles[0].revents) open = read_some(from.get(), result.output);
    if (result.output.size() > kMostOutput)
      throw DeviceError(Kind::kProtocol, what + " prints without end", "check its version");
    // What it printed before it ended is read first.
    if (handles[1].revents && !handles[0].revents) break;
  }
  result.exit_status = child.wait();
  return result;
}

}  // namespace wheatstone
