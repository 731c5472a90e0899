#pragma once
// A captured folder's raw frames against the journal of its session.

#include <cstdint>
#include <map>
#include <string>

#include "core/dataset.h"

namespace wheatstone {

/// Reads the journal once, if there is one.
class RawFiles {
 public:
  /// Errors: FileError (journal damaged).
  explicit RawFiles(const Dataset&);

  /// SHA-256 of a frame as it is on the disk, or of one that is gone as the journal says. The path
  /// is relative to the dataset.
  /// Errors: FileError: not the size or the contents that the journal says, not in the journal;
  /// without a journal: missing.
  std::string sha256(const std::string& file) const;

  /// FileError unless the frame is on the disk. Paths as above.
  void require(const std::string& file) const;

 private:
  Dataset dataset_;
  bool has_journal_ = false;
  struct Recorded {
    std::uintmax_t bytes = 0;
    std::string sha256;
  };
  std::map<std::string, Recorded> recorded_;  // by file
};

}  // namespace wheatstone
