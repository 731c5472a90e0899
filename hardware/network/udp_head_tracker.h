#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hardware/head_stream.h"
#include "hardware/transport/udp_receiver.h"

namespace wheatstone {

struct UdpHeadTrackerSettings {
  std::string address = "127.0.0.1";  // where to listen
  int port = 0;                       // 0: any free one
  std::string from;                   // IPv4 address of the tracker; empty: any
  std::string serial;                 // of the tracker; empty: any
};

/// A head tracker's stream over UDP, a sample per datagram. Nothing tells that a tracker is gone
/// rather than silent: both end in kTimeout.
class UdpHeadTracker final : public StreamedHeadTracker {
 public:
  /// Errors of UdpReceiver.
  explicit UdpHeadTracker(const UdpHeadTrackerSettings&, std::shared_ptr<Transcript> = nullptr);
  DeviceIdentity identity() const override;
  int port() const { return receiver_.port(); }

 private:
  std::vector<std::string> lines(const Deadline&) override;

  UdpReceiver receiver_;
};

}  // namespace wheatstone
