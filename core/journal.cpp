#include "core/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& action) {
  const int error = errno;
  throw FileError(path, "cannot " + action + " (" + std::strerror(error) + ")",
                  error == ENOSPC || error == EDQUOT || error == EFBIG
                      ? "free space on this disk, then run the command again"
                      : "check the folder and the disk");
}

/// Closes unless told to keep.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

/// Length up to the last line end.
std::size_t whole_lines(const std::string& text) {
  return text.find_last_of('\n') + 1;  // 0 without any
}

std::vector<nlohmann::json> parse(const std::filesystem::path& path, const std::string& text) {
  std::vector<nlohmann::json> records;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    nlohmann::json record =
        nlohmann::json::parse(text.begin() + static_cast<std::ptrdiff_t>(begin),
                              text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
    if (!record.is_object())
      throw FileError(path, "line " + std::to_string(records.size() + 1) + " is damaged",
                      "restore the file from a backup; nothing was changed");
    records.push_back(std::move(record));
    begin = end + 1;
  }
  return records;
}

}  // namespace

Journal::Journal(const std::filesystem::path& path) : path_(path) {
  Descriptor file{::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644)};
  if (file.fd < 0) fail(path, "open this journal");
  if (::flock(file.fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail(path, "lock this journal");
    throw FileError(path, "is in use by another process", "wait for that one to end");
  }
  std::string text = read_text(path);
  const std::size_t whole = whole_lines(text);
  if (whole != text.size()) {
    if (::ftruncate(file.fd, static_cast<off_t>(whole)) != 0 || ::fsync(file.fd) != 0)
      fail(path, "cut off an unfinished last line");
    text.resize(whole);
  }
  records_ = parse(path, text);
  sync_folder(path.parent_path());
  fd_ = std::exchange(file.fd, -1);
}

std::vector<nlohmann::json> Journal::read(const std::filesystem::path& path) {
  std::string text = read_text(path);
  text.resize(whole_lines(text));
  return parse(path, text);
}

Journal::~Journal() {
  ::close(fd_);
}

void Journal::append(const nlohmann::json& record) {
  WHEATSTONE_CHECK(record.is_object(), ==, true);
  const std::string line = record.dump() + '\n';
  const off_t before = ::lseek(fd_, 0, SEEK_END);
  std::size_t written = 0;
  while (before >= 0 && written < line.size()) {
    const ssize_t n = ::write(fd_, line.data() + written, line.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    written += static_cast<std::size_t>(n);
  }
  if (written < line.size() || ::fsync(fd_) != 0) {
    const int error = errno;
    // Should this fail as well, the next opening cuts off what is left of the line.
    [[maybe_unused]] const int cut = before < 0 ? -1 : ::ftruncate(fd_, before);
    errno = error;
    fail(path_, "write a record");
  }
  records_.push_back(record);
}

}  // namespace wheatstone
