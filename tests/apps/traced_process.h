#pragma once
// Ends a program at an exact point of its work with files: before its n-th system call that changes
// any. (Linux ptrace; the program's threads are followed.)

#include <string>
#include <vector>

namespace wheatstone::apps {

struct TracedEnd {
  bool killed = false;
  int status = -1;  // exit status if it was not killed
  int calls = 0;    // that change files, up to the end
  std::string last_call;
};

/// Runs the built program, its output discarded, and kills it before call number `kill_at` (from
/// 0); never if kill_at < 0. Throws std::runtime_error if it cannot be traced.
TracedEnd run_traced(const std::vector<std::string>& arguments, int kill_at);

}  // namespace wheatstone::apps
