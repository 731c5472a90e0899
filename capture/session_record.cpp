#include "capture/session_record.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/digest.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"

namespace wheatstone::detail {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kSchema = "wheatstone-session/1";

/// A folder in which no session was ever begun must not hold anybody's capture.
fs::path journal_path(const Dataset& dataset) {
  const fs::path journal = dataset.file(kJournalFile);
  if (!fs::exists(journal)) {
    if (fs::exists(dataset.file("dataset.json")))
      throw FileError(dataset.root(), "holds a dataset already", "choose another folder");
    if (fs::exists(dataset.file("raw")))
      throw FileError(dataset.file("raw"), "is there, but no session's journal",
                      "choose another folder");
    make_folder(journal.parent_path());
  }
  return journal;
}

TakenFrame frame_of(const json& record, const fs::path& file) {
  return {
      json_get<double>(record, "commanded_mm", file), json_get<double>(record, "reached_mm", file),
      json_get<double>(record, "exposure_s", file), json_get<std::uintmax_t>(record, "bytes", file),
      json_get<std::string>(record, "sha256", file)};
}

}  // namespace

std::map<std::string, TakenFrame> taken_frames(const Dataset& dataset,
                                               const std::vector<json>& records) {
  const fs::path file = dataset.file(kJournalFile);
  std::map<std::string, TakenFrame> taken;
  for (const json& record : records) {
    const auto event = json_get<std::string>(record, "event", file);
    if (event == "frame")
      taken[json_get<std::string>(record, "file", file)] = frame_of(record, file);
    if (event == "set aside") taken.erase(json_get<std::string>(record, "file", file));
  }
  return taken;
}

void require_same_setup(const Dataset& dataset, const json& first, const json& setup) {
  const fs::path file = dataset.file(kJournalFile);
  if (const auto schema = json_get<std::string>(first, "schema", file); schema != kSchema)
    throw FileError(file, "is a " + schema, std::string("this program reads ") + kSchema);
  json there = first;
  for (const char* key : {"schema", "event", "utc"}) there.erase(key);
  if (const std::string lines = difference(there, setup); !lines.empty())
    throw ArgumentError(dataset.root().string() + " holds a session with another plan:" + lines,
                        "ask for that plan to go on with it, or choose another folder");
}

SessionRecord::SessionRecord(const Dataset& dataset, const json& setup, Listener listener)
    : dataset_(dataset), listener_(std::move(listener)), journal_(journal_path(dataset)) {
  if (journal_.records().empty()) {
    json first = setup;
    first["schema"] = kSchema;
    add("session", first);
    return;
  }
  require_same_setup(dataset, journal_.records().front(), setup);
  taken_ = taken_frames(dataset, journal_.records());
  add("resumed", {{"frames", taken_.size()}});
}

void SessionRecord::add(const std::string& event, json record) {
  record["event"] = event;
  record["utc"] = utc_timestamp();
  journal_.append(record);
  if (event == "frame") taken_[record.at("file")] = frame_of(record, dataset_.file(kJournalFile));
  if (listener_) listener_(record);
}

const TakenFrame* SessionRecord::taken(const Shot& shot) const {
  const auto found = taken_.find(shot.file);
  return found == taken_.end() ? nullptr : &found->second;
}

bool SessionRecord::complete(const std::vector<Shot>& shots) const {
  return std::all_of(shots.begin(), shots.end(), [&](const Shot& s) { return taken(s); });
}

void SessionRecord::verify() {
  std::map<std::string, std::string> damaged;  // why, by file
  for (const auto& [file, frame] : taken_) {
    const fs::path path = dataset_.file(file);
    std::error_code error;
    if (const auto size = fs::file_size(path, error); error)
      damaged[file] = "is missing";
    else if (size != frame.bytes)
      damaged[file] = "has another size";
    else if (sha256_hex_of(path) != frame.sha256)
      damaged[file] = "has other contents";
  }
  for (const auto& [file, why] : damaged) set_aside(file, why);
}

void SessionRecord::set_aside(const std::string& file, const std::string& why) {
  const fs::path from = dataset_.file(file);
  json record = {{"file", file}, {"why", why}};
  if (fs::exists(from)) {
    // Numbered by records, so that no two have the same name.
    const std::string to = fmt::format("session/set_aside/{:04}_{}", journal_.records().size(),
                                       fs::path(file).filename().string());
    make_folder(dataset_.file(to).parent_path());
    std::error_code error;
    fs::rename(from, dataset_.file(to), error);
    if (error) throw FileError(from, "cannot be set aside (" + error.message() + ")", "move it");
    sync_folder(from.parent_path());
    sync_folder(dataset_.file(to).parent_path());
    record["moved_to"] = to;
  }
  add("set aside", record);
  taken_.erase(file);
}

double SessionRecord::unfinished_exposure_s() const {
  const auto& records = journal_.records();
  const auto last = std::find_if(records.rbegin(), records.rend(), [](const json& r) {
    return r.at("event") == "trigger" || r.at("event") == "frame";
  });
  return last == records.rend() || last->at("event") == "frame"
             ? 0
             : json_get<double>(*last, "exposure_s", dataset_.file(kJournalFile));
}

}  // namespace wheatstone::detail
