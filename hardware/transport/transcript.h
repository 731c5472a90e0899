#pragma once
// What went over a wire, for looking and for replaying.

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"

namespace wheatstone {

/// Appends one line per message, {"ns": 1234, "to": "device", "hex": "6d3530"}, to a file (JSON
/// lines; "to" is "device" or "host"; ns on the machine's monotonic clock). Any thread. A
/// transcript that cannot be written any more is given up silently: the device matters more.
class Transcript {
 public:
  Transcript() = default;  // records nothing
  /// Throws FileError if the file cannot be made.
  explicit Transcript(const std::filesystem::path&);
  ~Transcript();
  Transcript(const Transcript&) = delete;
  Transcript& operator=(const Transcript&) = delete;

  void to_device(std::string_view bytes) { add("device", bytes); }
  void to_host(std::string_view bytes) { add("host", bytes); }

 private:
  void add(const char* to, std::string_view bytes);

  std::mutex mutex_;
  int handle_ = -1;
};

struct TranscriptEntry {
  Nanoseconds ns = 0;
  bool to_device = false;
  std::string bytes;
};
/// Throws FileError, naming the line, for anything that Transcript does not write.
std::vector<TranscriptEntry> read_transcript(const std::filesystem::path&);

/// "41 0d" for messages that people read; at most `longest` bytes, then "...".
std::string hex_of(std::string_view bytes, std::size_t longest = 32);
/// What devices say, fit for a terminal: other than printable ASCII becomes '?'.
std::string printable(std::string_view text);

}  // namespace wheatstone
