#pragma once

#include <functional>
#include <optional>

#include "sim/wire/still/ptp_camera_firmware.h"
#include "sim/wire/usb/usb_firmware.h"

namespace wheatstone {

/// The emulated camera body as a USB device: class 6/1/1, with the ids of a Sony alpha 7R III.
class StillUsbFirmware final : public UsbFirmware {
 public:
  static constexpr std::uint16_t kPcRemote = 0x0c33, kFilesOnly = 0x0c00;
  static constexpr std::uint8_t kBulkIn = 0x81, kBulkOut = 0x02, kEvents = 0x83;

  explicit StillUsbFirmware(PtpCameraFirmware& camera, std::uint16_t product = kPcRemote)
      : camera_(camera), product_(product) {}

  UsbDescription description() const override;
  UsbReply control(const UsbSetup&, std::span<const std::uint8_t> data, Nanoseconds now) override;
  UsbReply receive(std::uint8_t endpoint, std::span<const std::uint8_t>, Nanoseconds now) override;
  UsbReply send(std::uint8_t endpoint, std::size_t longest, Nanoseconds now) override;
  void halt_cleared(std::uint8_t) override { camera_.clear_halt(); }
  void reset() override { camera_.reset(); }
  Nanoseconds next_event() const override { return camera_.next_event(); }

  /// A fault: ends a transfer in its place; none: as it should.
  std::function<std::optional<UsbReply::End>(std::uint8_t endpoint)> meet;

 private:
  PtpCameraFirmware& camera_;
  std::uint16_t product_;
};

}  // namespace wheatstone
