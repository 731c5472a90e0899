#include "hardware/rig_file/led_keys.h"

#include "core/error.h"

namespace wheatstone {

LedMapping read_led_mapping(const TomlTable& table) {
  constexpr int kMost = 512;
  LedMapping m;
  m.rows = static_cast<int>(table.integer_or("rows", m.rows, 1, kMost));
  m.columns = static_cast<int>(table.integer_or("columns", m.columns, 1, kMost));
  m.corner = table.text_or("corner", m.corner);
  m.serpentine = table.flag_or("serpentine", m.serpentine);
  const std::string lines = table.text_or("lines", "rows");
  if (lines != "rows" && lines != "columns") table.fail("lines", R"(must be "rows" or "columns")");
  m.along_rows = lines == "rows";
  try {
    places_on_wire(m);
  } catch (const ArgumentError& e) {
    table.fail("corner", e.what());
  }
  return m;
}

}  // namespace wheatstone
