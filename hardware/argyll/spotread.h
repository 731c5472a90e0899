#pragma once
// Any instrument that ArgyllCMS drives, through its program spotread (docs/hardware/spotread.md).

#include <mutex>
#include <stop_token>
#include <string>

#include "hardware/spectroradiometer.h"

namespace wheatstone {

struct SpotreadSettings {
  std::string program = "spotread";  // looked up in PATH unless it has a slash
  int port = 1;                      // of the instruments that `spotread -?` lists
  double floor_cd_m2 = 0.1;          // of the instrument, by its data sheet
};

/// Runs spotread once for each reading. It chooses its integration itself, and has no aiming light
/// that could be switched.
class Spotread final : public Spectroradiometer {
 public:
  /// Throws kNotFound if there is no such program. The instrument is not touched.
  explicit Spotread(const SpotreadSettings&);

  DeviceIdentity identity() const override { return identity_; }
  /// Wavelengths are those of the last reading; 0 before there was one.
  SpectroradiometerRange range() const override { return range_; }
  /// Throws kOutOfRange also for an integration time or a period other than the default.
  void configure(const Settings&, Deadline) override;
  /// Averages several readings itself. Throws also kRefused with the last line that spotread said.
  SpectralReading measure(Deadline) override;
  /// Throws kRefused for `on`.
  void aim(bool on, Deadline) override;
  void abort() noexcept override;

 private:
  SpectralReading measure_once(const Deadline&);

  SpotreadSettings settings_;
  DeviceIdentity identity_;
  SpectroradiometerRange range_;
  int average_ = 1;
  std::mutex mutex_;
  std::stop_source stop_;  // of the reading that is under way
};

}  // namespace wheatstone
