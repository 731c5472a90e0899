#pragma once
// An append-only record of what happened: one JSON object per line, never changed afterwards.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace wheatstone {

/// Keeps the file open and locked, so that one process at a time writes to it.
class Journal {
 public:
  /// Opens the file, or creates it in a folder that must exist. A last line without its line end,
  /// which only a crash in the middle of a write leaves behind, was never acknowledged and is cut
  /// off. Errors: FileError: no such folder, no permission, in use by another process, damaged
  /// (with the line).
  explicit Journal(const std::filesystem::path&);
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// The records of a journal that another process may be writing to, without an unfinished last
  /// line. Errors: FileError: missing, unreadable, damaged (with the line).
  static std::vector<nlohmann::json> read(const std::filesystem::path&);

  /// All records, oldest first.
  const std::vector<nlohmann::json>& records() const { return records_; }

  /// The record is on the disk when this returns; if it throws, the file is as it was.
  /// Errors: FileError: disk full, disk fault.
  void append(const nlohmann::json&);

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::vector<nlohmann::json> records_;
};

}  // namespace wheatstone
