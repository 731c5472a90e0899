#pragma once

#include <string>
#include <vector>

#include "sim/spectroradiometer.h"
#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// A JETI specbos 1211 (docs/hardware/jeti.md) over a SpectroradiometerModel.
class JetiFirmware final : public SerialFirmware {
 public:
  explicit JetiFirmware(World& world, double gain = 1) : world_(world), model_(world, {}, gain) {}

  void receive(std::string_view, Nanoseconds now) override;
  std::string run(Nanoseconds now) override;
  Nanoseconds next_event() const override;

  std::string name = "JETI_SB1211";
  std::string version = "1.50";  // may have several lines, ended by carriage returns
  int number = 1211042;
  int first_nm = 380, last_nm = 780;
  bool diffuser_on = false;
  bool has_xyz = true;            // some firmware has not
  bool calibrated_widely = true;  // false: 380 to 780 nm only
  int enq_every = 0;              // a stray ENQ after so many bytes; 0: none

  // Faults.
  int refuse_with = 0;         // answers *init with this error at its end
  int lose_lines_of = 0;       // so many spectra lose lines on the way
  bool laser_stuck = false;    // on
  double xyz_factor = 1;       // its own XYZ is so many times what it should be
  std::string answer_instead;  // to everything but *idn?
  bool never_done = false;     // *init does not end

  // The truth.
  bool laser() const { return laser_; }
  bool measuring() const { return done_ != kNever || stuck_; }
  int integrations() const { return static_cast<int>(measurements_); }
  double longest_s() const { return longest_s_; }
  int average() const { return average_; }
  double period_s() const { return synchronised_ ? period_s_ : 0; }

 private:
  void command(const std::string& line, Nanoseconds now);
  void finish();
  void nak(int code);
  void ack() { answers_ += '\x06'; }
  void text(const std::string& line) { answers_ += line + "\r"; }
  std::string spectrum();
  Eigen::Vector3d own_xyz() const;

  World& world_;
  SpectroradiometerModel model_;
  std::string line_, answers_;
  std::size_t sent_ = 0;
  int error_ = 0;
  bool laser_ = true, synchronised_ = false, stuck_ = false;
  int average_ = 1, wanted_first_nm_ = 380, wanted_last_nm_ = 780;
  double longest_s_ = 60, period_s_ = 0;
  Nanoseconds done_ = kNever;
  std::uint64_t measurements_ = 0;
  SpectroradiometerModel::Exposure exposure_;
};

}  // namespace wheatstone
