#pragma once
// The books of a capture session: which frames are taken and whether their files are still what
// was written. Internal to capture/.

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/plan.h"
#include "core/dataset.h"
#include "core/journal.h"

namespace wheatstone::detail {

/// A frame that counts, as its record says.
struct TakenFrame {
  double commanded_mm = 0, reached_mm = 0, exposure_s = 0;
  std::uintmax_t bytes = 0;
  std::string sha256;
};
/// The frames that count after all these records, by file. Errors: FileError naming the journal.
std::map<std::string, TakenFrame> taken_frames(const Dataset&,
                                               const std::vector<nlohmann::json>& records);

/// Throws ArgumentError, listing what differs, unless the session that begins with this record has
/// this setup; FileError if the record is of another schema.
void require_same_setup(const Dataset&, const nlohmann::json& first_record,
                        const nlohmann::json& setup);

/// The journal with what follows from it. Paths are relative to the dataset.
class SessionRecord {
 public:
  using Listener = std::function<void(const nlohmann::json&)>;

  /// Opens or starts the session. `setup` says what the session is (plan, rig, manifest).
  /// Errors: as capture_light_field().
  SessionRecord(const Dataset&, const nlohmann::json& setup, Listener);

  /// Adds a record of this kind, with the wall clock's time.
  void add(const std::string& event, nlohmann::json record);

  /// Null unless the shot's frame counts.
  const TakenFrame* taken(const Shot& shot) const;
  bool complete(const std::vector<Shot>&) const;

  /// Compares every frame's file with its record; what differs no longer counts, and its file is
  /// set aside.
  void verify();
  /// The frame no longer counts; its file is moved to session/set_aside/.
  void set_aside(const std::string& file, const std::string& why);

  /// Exposure of a frame that was triggered last and never recorded: the shutter may be open.
  double unfinished_exposure_s() const;

 private:
  const Dataset& dataset_;  // must outlive this
  Listener listener_;
  Journal journal_;
  std::map<std::string, TakenFrame> taken_;  // by file
};

inline constexpr const char* kJournalFile = "session/journal.jsonl";

}  // namespace wheatstone::detail
