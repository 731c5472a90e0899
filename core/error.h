#pragma once
// One family of exceptions for the whole program (docs/architecture.md, "Errors").

#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>

namespace wheatstone {

/// Something the person at the machine can act on. what() is "<problem>; <remedy>".
class Error : public std::runtime_error {
 public:
  Error(const std::string& problem, const std::string& remedy)
      : std::runtime_error(remedy.empty() ? problem : problem + "; " + remedy) {}
};

/// A file that is missing, damaged, of the wrong kind, or cannot be written.
class FileError : public Error {
 public:
  FileError(const std::filesystem::path& path, const std::string& problem,
            const std::string& remedy)
      : Error(path.string() + ": " + problem, remedy), path_(path) {}
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// An argument or a set of measurements from which no answer can be computed.
class ArgumentError : public Error {
 public:
  using Error::Error;
};

/// A graphics context or shader that cannot be had on this machine.
class GraphicsError : public Error {
 public:
  using Error::Error;
};

/// Ctrl-C or a cancelled token. The data written so far is complete and resumable.
class Cancelled : public Error {
 public:
  explicit Cancelled(const std::string& what) : Error(what, "run the same command to resume") {}
};

/// A broken promise of our own code; never the user's fault.
class InternalError : public Error {
 public:
  explicit InternalError(const std::string& what)
      : Error("internal error: " + what, "please report this with the command that led to it") {}
};

namespace detail {
template <class A, class B>
[[noreturn]] void check_failed(const char* expression, const char* file, int line, const A& a,
                               const B& b) {
  std::ostringstream out;
  out << file << ":" << line << ": " << expression << " (" << a << " against " << b << ")";
  throw InternalError(out.str());
}
}  // namespace detail

/// Our own invariants: WHEATSTONE_CHECK(a, ==, b) throws InternalError with both operands.
#define WHEATSTONE_CHECK(a, op, b)                                                            \
  do {                                                                                        \
    const auto& wheatstone_a = (a);                                                           \
    const auto& wheatstone_b = (b);                                                           \
    if (!(wheatstone_a op wheatstone_b))                                                      \
      ::wheatstone::detail::check_failed(#a " " #op " " #b, __FILE__, __LINE__, wheatstone_a, \
                                         wheatstone_b);                                       \
  } while (false)

}  // namespace wheatstone
