#pragma once
// The outputs of an X server (RandR 1.3, spoken through xcb: it neither ends the program when the
// server dies nor waits without a deadline, as Xlib would).

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hardware/display_outputs.h"

namespace wheatstone {

struct XrandrSettings {
  std::string display;                     // ":0"; empty: as the variable DISPLAY says
  Duration restoring = Duration::of(0.5);  // the destructor gives up after so long
};

class XrandrOutputs final : public DisplayOutputs {
 public:
  /// Throws kNotFound if no server answers, kRefused if it has no RandR 1.3, kTimeout. A server
  /// that takes the connection and then says nothing holds this call up; none of the others.
  XrandrOutputs(const XrandrSettings&, const Deadline&);
  /// Restores the gamma tables, as far as the server answers.
  ~XrandrOutputs() override;
  XrandrOutputs(const XrandrOutputs&) = delete;
  XrandrOutputs& operator=(const XrandrOutputs&) = delete;

  DeviceIdentity identity() const override { return identity_; }
  std::vector<DisplayOutput> enumerate(Deadline) override;
  void neutralise(Deadline) override;

 private:
  class Server;
  struct Table {
    std::uint32_t crtc = 0;
    std::vector<std::uint16_t> red, green, blue;
  };

  Table read_table(std::uint32_t crtc, const Deadline&);
  void write_table(const Table&, const Deadline&);

  XrandrSettings settings_;
  DeviceIdentity identity_;
  std::unique_ptr<Server> server_;
  std::vector<Table> found_;  // what the tables were before neutralise()
};

}  // namespace wheatstone
