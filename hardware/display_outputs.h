#pragma once
// The machine's video outputs: which display hangs where, and whether the way to it is unspoilt.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "hardware/device.h"

namespace wheatstone {

/// As in the display's EDID (VESA E-EDID 1.4).
struct EdidIdentity {
  std::string manufacturer;  // three letters
  std::uint16_t product = 0;
  std::uint32_t serial = 0;
  std::string name, serial_text;  // of the text descriptors; empty where there are none
  friend bool operator==(const EdidIdentity&, const EdidIdentity&) = default;
};

struct DisplayOutput {
  std::string connector;  // "HDMI-1"
  EdidIdentity edid;      // empty where the display has none, or a damaged one
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;  // 0 x 0: it is off
  double refresh_hz = 0;                                // 0: unknown
  int bits_per_channel = 0;
  int gamma_size = 0;
  bool gamma_is_identity = false;
  bool is_scaled = false;  // a transform, a border, a scaling mode: pixels are not the panel's
  // What the video driver says of the way to the display; empty or 0 where it does not.
  std::string dithering;           // its own: "off", "auto", "dynamic 2x2", ...
  int link_bits_per_channel = 0;   // the most that it sends
  std::string range;               // of the codes: "Full", "Automatic", "Limited 16:235"
  bool has_colour_matrix = false;  // one that is not identity
};

/// One role's display as the rig file wants it.
struct WantedOutput {
  std::string role;  // "left_near_lcd", ...
  EdidIdentity edid;
  std::string connector;  // where several displays have the same EDID; empty otherwise
  int width_px = 0, height_px = 0;
  double refresh_hz = 0;  // 0: any
  int bits_per_channel = 0;
};

struct OutputProblem {
  std::string role, check, found, remedy;
};

class DisplayOutputs : public Device {
 public:
  /// All to which a display is connected.
  virtual std::vector<DisplayOutput> enumerate(Deadline) = 0;
  /// Sets every gamma table to identity and reads it back; restored by the destructor. Throws
  /// kFault if one stays as it was.
  virtual void neutralise(Deadline) = 0;
};

/// All that is not as wanted; empty when everything is. Never binds by guess: two displays that
/// answer the same wish are a problem.
std::vector<OutputProblem> verify(const std::vector<DisplayOutput>&,
                                  const std::vector<WantedOutput>&);

/// The only display that answers the wish; null where there is none, or several.
const DisplayOutput* find_output(const std::vector<DisplayOutput>&, const WantedOutput&);
/// "LCD at DP-1, dithering off, at most 10 bits, range Full", for people.
std::string describe(const DisplayOutput&);

/// Entry i of the identity table of `size` >= 2 entries, and whether a table is one, to half a step
/// of 10 bits.
int identity_gamma(std::size_t i, std::size_t size);
bool is_identity_gamma(std::span<const std::uint16_t>);

}  // namespace wheatstone
