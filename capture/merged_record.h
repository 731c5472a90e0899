#pragma once
// hdr/<view>.json: what a merged view was made from and which bytes came out, so that a file that
// fits neither any more is noticed (docs/dataset.md).

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "capture/lamp_drift.h"

namespace wheatstone {

struct MergedRecord {
  std::string made_from;                   // fingerprint of all that the light depends on
  std::uintmax_t bytes = 0;                // of the EXR
  std::string sha256;                      // of the EXR
  double saturated = 0, underexposed = 0;  // shares of its pixels
  struct Lamp {
    LampCorrection correction;
    std::string reference_view;  // whose lamps this one was brought to
  };
  std::optional<Lamp> lamp;  // if the lamps' drift was taken out
};

/// Nothing if the file is missing, damaged or of another schema: the view is then made again.
std::optional<MergedRecord> read_merged_record(const std::filesystem::path&);
/// Atomically. Errors: FileError.
void write_merged_record(const std::filesystem::path&, const MergedRecord&);

/// Whether the EXR is, to the byte, the one of the record. Errors: FileError (unreadable).
bool holds_what_was_written(const MergedRecord&, const std::filesystem::path& exr);

}  // namespace wheatstone
