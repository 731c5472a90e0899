#pragma once
// A photodiode behind a microcontroller on a serial line; the protocol is ours
// (docs/hardware/photodiode.md).

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "hardware/light_sensor.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {

struct SerialPhotodiodeSettings {
  std::filesystem::path line;  // "/dev/serial/by-id/..."
  int baud = 921600;
  std::string serial;                   // the sensor's own; empty: any
  Duration answer = Duration::of(0.5);  // to its identity, when it is opened
};

class SerialPhotodiode final : public LightSensor {
 public:
  static constexpr std::uint32_t kMostSamples = 10'000'000;

  /// Errors of SerialPort; kTimeout, kProtocol if it is no photodiode; kFault for another serial or
  /// a rate that it cannot have.
  explicit SerialPhotodiode(const SerialPhotodiodeSettings&, std::shared_ptr<Transcript> = nullptr);
  ~SerialPhotodiode() override;

  DeviceIdentity identity() const override { return identity_; }
  /// start_ns is right within half the fastest of a few round trips of a question.
  /// Throws kOutOfRange for less than one sample or more than kMostSamples, kRefused if it says so.
  LightTrace record(Duration, Deadline) override;

 private:
  std::string ask(const std::string& question, const Deadline&);
  void end_recording(const Deadline&);
  /// The machine's clock minus the device's, at this device time.
  struct Sync {
    Nanoseconds host_ns = 0, round_trip_ns = 0;
    std::uint32_t device_us = 0;
  };
  Sync synchronise(const Deadline&);
  void receive(LightTrace&, std::size_t count, const Deadline&);

  SerialPort port_;
  DeviceIdentity identity_;
  std::uint32_t samples_per_s_ = 0;
  std::uint32_t tag_ = 0;   // of the last question for the time
  bool recording_ = false;  // as far as we know: it may still send samples
};

}  // namespace wheatstone
