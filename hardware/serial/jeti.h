#pragma once
// JETI specbos 1211 and its kin on a serial line (docs/hardware/jeti.md).

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hardware/serial/jeti_message.h"
#include "hardware/spectroradiometer.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {

struct JetiSettings {
  std::filesystem::path line;           // "/dev/serial/by-id/..."
  int baud = 0;                         // 0: 921600, 115200 and 38400 are tried in this order
  std::string serial;                   // its spectrometer number; empty: any
  Duration answer = Duration::of(0.5);  // to its name, at each speed
  double floor_cd_m2 = 0.1;             // of the model, by its data sheet
  Duration quiet = Duration::of(0.15);  // after so long a spectrum has no more lines
};

class Jeti final : public Spectroradiometer {
 public:
  /// Switches the aiming light off and puts its settings to what this driver wants.
  /// Errors of SerialPort; kTimeout if nothing answers at any speed; kProtocol if it is no specbos;
  /// kFault for another serial.
  explicit Jeti(const JetiSettings&, std::shared_ptr<Transcript> = nullptr);
  ~Jeti() override;

  DeviceIdentity identity() const override { return identity_; }
  SpectroradiometerRange range() const override { return range_; }
  void configure(const Settings&, Deadline) override;
  /// Takes about 3.6 s and twice the integration. A spectrum that lost lines on its way is asked
  /// for again, five times in all. The reading's integration stays 0: the device adapts it, and no
  /// command that we know tells which it took. Throws also kNotReady while the diffuser is on, and
  /// kRefused.
  SpectralReading measure(Deadline) override;
  void aim(bool on, Deadline) override;
  void abort() noexcept override;

 private:
  std::string firmware_version(const Deadline&);
  void find_speed(const std::shared_ptr<Transcript>&);
  void set_up(const Deadline&);
  JetiToken next(const Deadline&);
  void send(const std::string& command, const Deadline&);
  std::string query(const std::string& command, const Deadline&);
  void set(const std::string& command, const Deadline&);
  int error_code(const Deadline&);
  [[noreturn]] void refused(const std::string& command, const Deadline&);
  void set_range(double first_nm, double last_nm, const Deadline&);
  void expose(const Deadline&);
  std::vector<double> fetch_values(const Deadline&);
  SpectralRadiance fetch_spectrum(const Deadline&);
  Eigen::Vector3d fetch_xyz(const Deadline&);
  void get_in_step(const Deadline&);
  /// Runs one exchange; after an error we do not know what is still on its way.
  template <class Exchange>
  void exchange(const Deadline&, const Exchange&);

  JetiSettings settings_;
  std::unique_ptr<SerialPort> port_;
  std::string input_;
  DeviceIdentity identity_;
  SpectroradiometerRange range_;
  bool in_step_ = false;  // the next byte from the device belongs to the next command
  bool aiming_ = false;   // as far as we know: it may be
  std::atomic<bool> measuring_ = false, aborted_ = false;
};

}  // namespace wheatstone
