#include "capture/raw_files.h"

#include <fmt/format.h>

#include "capture/session_record.h"
#include "core/digest.h"
#include "core/error.h"

namespace wheatstone {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRemedy =
    "run the same capture again: it takes anew what is missing or damaged";

}  // namespace

RawFiles::RawFiles(const Dataset& dataset) : dataset_(dataset) {
  const fs::path journal = dataset.file(detail::kJournalFile);
  has_journal_ = fs::exists(journal);
  if (!has_journal_) return;
  for (const auto& [name, frame] : detail::taken_frames(dataset, Journal::read(journal)))
    for (const detail::WrittenFile& f : frame.files) recorded_[f.file] = {f.bytes, f.sha256};
}

std::string RawFiles::sha256(const std::string& file) const {
  const fs::path path = dataset_.file(file);
  const auto recorded = recorded_.find(file);
  if (has_journal_ && recorded == recorded_.end())
    throw FileError(path, "is no frame of the session's journal", kRemedy);
  if (!fs::exists(path)) {
    if (!has_journal_) require(file);
    return recorded->second.sha256;
  }
  const std::string sha256 = sha256_hex_of(path);
  if (!has_journal_) return sha256;
  if (const auto bytes = fs::file_size(path); bytes != recorded->second.bytes)
    throw FileError(
        path,
        fmt::format("has {} bytes, but {} by the session's journal", bytes, recorded->second.bytes),
        kRemedy);
  if (sha256 != recorded->second.sha256)
    throw FileError(path, "has other contents than the session's journal says", kRemedy);
  return sha256;
}

void RawFiles::require(const std::string& file) const {
  if (!fs::exists(dataset_.file(file))) throw FileError(dataset_.file(file), "is missing", kRemedy);
}

}  // namespace wheatstone
