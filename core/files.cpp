#include "core/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <regex>

#include "core/error.h"

namespace wheatstone {

namespace fs = std::filesystem;

namespace {

class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

std::string remedy_for(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free space on this disk, then run the command again";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder you may write to";
    default:
      return "check the path and the disk";
  }
}

[[noreturn]] void fail(const fs::path& path, const std::string& action, int error) {
  throw FileError(path, "cannot " + action + " (" + std::strerror(error) + ")", remedy_for(error));
}

void sync_to_disk(const fs::path& path, int flags, const fs::path& named) {
  Descriptor file(path, flags);
  if (file.get() < 0) fail(named, "open for flushing", errno);
  if (::fsync(file.get()) != 0) fail(named, "flush to disk", errno);
}

}  // namespace

void write_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  static std::atomic<unsigned> counter{0};
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw FileError(path, "cannot be written: there is no folder " + folder.string(),
                    "create the folder first");
  if (::access(folder.c_str(), W_OK) != 0) fail(path, "write here", errno);
  if (fs::is_directory(path, error))
    throw FileError(path, "cannot be written: it is a folder", "choose another name");
  const fs::path temporary =
      folder / ("." + path.stem().string() + "." + std::to_string(::getpid()) + "." +
                std::to_string(counter++) + ".part" + path.extension().string());
  try {
    write(temporary);
    sync_to_disk(temporary, O_RDONLY, path);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "move into place", errno);
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
  sync_folder(folder);
}

void sync_folder(const fs::path& path) {
  sync_to_disk(path.empty() ? fs::path(".") : path, O_RDONLY | O_DIRECTORY, path);
}

void remove_unfinished(const fs::path& folder) {
  static const std::regex kTemporary(R"(\..*\.(\d{1,9})\.\d+\.part(\..*)?)");
  std::error_code error;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::smatch parts;
    if (std::regex_match(name, parts, kTemporary) &&
        ::kill(static_cast<pid_t>(std::stol(parts[1])), 0) != 0 && errno == ESRCH)
      left.push_back(entry.path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

void write_bytes_atomically(const fs::path& path, std::span<const std::byte> bytes) {
  write_atomically(path, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    if (!out) fail(path, "create", errno);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) fail(path, "write", errno != 0 ? errno : EIO);
  });
}

void write_text_atomically(const fs::path& path, const std::string& text) {
  write_bytes_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

std::vector<std::byte> read_bytes(const fs::path& path, std::size_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw FileError(path, "is missing", "check the path");
  if (!fs::is_regular_file(status))
    throw FileError(path, "is not a regular file", "give the path of a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) fail(path, "read its size", error.value());
  if (size > max_bytes)
    throw FileError(path,
                    "has " + std::to_string(size) + " bytes, more than the " +
                        std::to_string(max_bytes) + " expected at most",
                    "check that this is the right file");
  std::vector<std::byte> bytes(size);
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "open", errno);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(in.gcount()) != size)
    throw FileError(path, "ended early while it was read", "check the disk");
  return bytes;
}

std::string read_text(const fs::path& path, std::size_t max_bytes) {
  const std::vector<std::byte> bytes = read_bytes(path, max_bytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) fail(path, "create this folder", error.value());
  if (!fs::is_directory(path)) throw FileError(path, "is not a folder", "choose another name");
}

}  // namespace wheatstone
