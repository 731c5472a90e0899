#include "traced_process.h"

#include <fcntl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>
#include <stdexcept>

#include "program.h"

namespace wheatstone::apps {
namespace {

/// The calls with which files come to be, change and go.
const std::map<std::uint64_t, std::string>& changing_calls() {
  static const std::map<std::uint64_t, std::string> calls = {
#ifdef SYS_open
      {SYS_open, "open"},       {SYS_rename, "rename"},     {SYS_mkdir, "mkdir"},
      {SYS_unlink, "unlink"},   {SYS_rmdir, "rmdir"},
#endif
      {SYS_openat, "open"},     {SYS_renameat, "rename"},   {SYS_renameat2, "rename"},
      {SYS_mkdirat, "mkdir"},   {SYS_unlinkat, "unlink"},   {SYS_write, "write"},
      {SYS_pwrite64, "write"},  {SYS_writev, "write"},      {SYS_fsync, "fsync"},
      {SYS_fdatasync, "fsync"}, {SYS_ftruncate, "truncate"}};
  return calls;
}

/// Opening counts where it may create or empty a file.
bool changes(const __ptrace_syscall_info& info) {
  const auto call = info.entry.nr;
  if (call == SYS_openat) return (info.entry.args[2] & (O_CREAT | O_TRUNC)) != 0;
#ifdef SYS_open
  if (call == SYS_open) return (info.entry.args[1] & (O_CREAT | O_TRUNC)) != 0;
#endif
  // Not what it says on its standard output and error.
  if (call == SYS_write || call == SYS_writev) return info.entry.args[0] > 2;
  return changing_calls().contains(call);
}

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string(what) + ": " + std::strerror(errno));
}

}  // namespace

TracedEnd run_traced(const std::vector<std::string>& arguments, int kill_at) {
  const pid_t child = ::fork();
  if (child < 0) fail("fork");
  if (child == 0) {
    ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    ::raise(SIGSTOP);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    // The leak checker traces its own process, which a traced one may not.
    become_program(arguments, {{"ASAN_OPTIONS=detect_leaks=0"}, {}});
  }
  int status = 0;
  if (::waitpid(child, &status, 0) != child || !WIFSTOPPED(status)) fail("waitpid");
  constexpr long kOptions = PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL | PTRACE_O_TRACECLONE;
  if (::ptrace(PTRACE_SETOPTIONS, child, nullptr, kOptions) != 0) fail("ptrace");
  ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);

  TracedEnd end;
  while (true) {
    const pid_t stopped = ::waitpid(-1, &status, __WALL);
    if (stopped < 0) fail("waitpid");
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (stopped != child) continue;  // one of its threads
      if (WIFEXITED(status)) end.status = WEXITSTATUS(status);
      return end;
    }
    long signal = 0;
    if (WSTOPSIG(status) == (SIGTRAP | 0x80)) {
      __ptrace_syscall_info info{};
      ::ptrace(PTRACE_GET_SYSCALL_INFO, stopped, sizeof info, &info);
      if (info.op == PTRACE_SYSCALL_INFO_ENTRY && changes(info)) {
        end.last_call = changing_calls().at(info.entry.nr);
        if (end.calls++ == kill_at) {
          end.killed = true;
          ::kill(child, SIGKILL);
          while (::waitpid(-1, &status, __WALL) > 0) {
          }
          return end;
        }
      }
    } else if (WSTOPSIG(status) != SIGTRAP && WSTOPSIG(status) != SIGSTOP) {
      signal = WSTOPSIG(status);  // the program's own
    }
    ::ptrace(PTRACE_SYSCALL, stopped, nullptr, signal);
  }
}

}  // namespace wheatstone::apps
