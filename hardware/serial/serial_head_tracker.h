#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hardware/head_stream.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {

struct SerialHeadTrackerSettings {
  std::filesystem::path line;  // "/dev/serial/by-id/..."
  int baud = 115200;
  std::string serial;  // of the tracker; empty: any
};

/// A head tracker's stream on a serial line, a line feed after each sample. What comes up to the
/// first one is dropped: the line may have been opened in the middle of a sample.
class SerialHeadTracker final : public StreamedHeadTracker {
 public:
  /// Errors of SerialPort.
  explicit SerialHeadTracker(const SerialHeadTrackerSettings&,
                             std::shared_ptr<Transcript> = nullptr);
  DeviceIdentity identity() const override;

 private:
  std::vector<std::string> lines(const Deadline&) override;
  void fill(const Deadline&);

  SerialPort port_;
  bool in_step_ = false;
  std::string rest_;  // of a sample that has not come as a whole
};

}  // namespace wheatstone
