#pragma once
// Every written file is complete or absent: written aside, flushed to disk, renamed.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

/// Calls write(temporary) with a path beside `path` (same folder and extension, so that a library
/// that looks at the name is content), then fsyncs it and renames it to `path`, then fsyncs the
/// folder. If anything throws or fails, the temporary is removed and `path` is as it was.
/// Errors: FileError naming `path`: no such folder, no permission, no space left.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same for bytes and text held in memory.
void write_bytes_atomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_text_atomically(const std::filesystem::path& path, const std::string& text);

/// Removes from the folder, if there is one, the temporaries of processes that were killed while
/// they wrote; those of living processes of this machine stay.
void remove_unfinished(const std::filesystem::path& folder);

/// Whole file. FileError if missing, unreadable, or larger than max_bytes.
std::vector<std::byte> read_bytes(const std::filesystem::path& path,
                                  std::size_t max_bytes = std::size_t{1} << 31);
std::string read_text(const std::filesystem::path& path,
                      std::size_t max_bytes = std::size_t{1} << 28);

/// Flushes the names in a folder to disk: what was created, renamed or removed in it stays so.
void sync_folder(const std::filesystem::path&);

/// Creates the folder and its parents. FileError names the folder and why not.
void make_folder(const std::filesystem::path& path);

}  // namespace wheatstone
