#include "capture/merged_record.h"

#include "core/digest.h"
#include "core/error.h"
#include "core/json.h"

namespace wheatstone {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kSchema = "wheatstone-merged/1";

}  // namespace

std::optional<MergedRecord> read_merged_record(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  try {
    const json j = read_json(file, kSchema);
    MergedRecord out{
        json_get<std::string>(j, "made_from", file), json_get<std::uint64_t>(j, "bytes", file),
        json_get<std::string>(j, "sha256", file),    json_get<double>(j, "saturated", file),
        json_get<double>(j, "underexposed", file),   {}};
    if (const json lamp = json_get<json>(j, "lamp", file); !lamp.is_null())
      out.lamp = {{json_get<double>(lamp, "factor", file), json_get<double>(lamp, "sigma", file)},
                  json_get<std::string>(lamp, "reference_view", file)};
    return out;
  } catch (const FileError&) {
    return std::nullopt;
  }
}

void write_merged_record(const fs::path& file, const MergedRecord& record) {
  json lamp;
  if (record.lamp)
    lamp = {{"factor", record.lamp->correction.factor},
            {"sigma", record.lamp->correction.sigma},
            {"reference_view", record.lamp->reference_view}};
  write_json(file, kSchema,
             {{"made_from", record.made_from},
              {"bytes", record.bytes},
              {"sha256", record.sha256},
              {"saturated", record.saturated},
              {"underexposed", record.underexposed},
              {"lamp", lamp}});
}

bool holds_what_was_written(const MergedRecord& record, const fs::path& exr) {
  return fs::exists(exr) && fs::file_size(exr) == record.bytes &&
         sha256_hex_of(exr) == record.sha256;
}

}  // namespace wheatstone
