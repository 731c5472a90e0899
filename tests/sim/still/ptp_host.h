#pragma once
// A host that talks to the camera's firmware without a wire.

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sim/wire/still/little_endian.h"
#include "sim/wire/still/ptp_camera_firmware.h"

namespace wheatstone {

class PtpHost {
 public:
  explicit PtpHost(PtpCameraFirmware& camera) : camera_(camera) {}

  struct Answer {
    std::uint16_t code = 0;
    std::vector<std::byte> data;
  };

  /// Nothing: the camera does not answer, or halts.
  std::optional<Answer> ask(std::uint16_t operation, std::vector<std::uint32_t> parameters = {},
                            std::optional<std::vector<std::byte>> data = std::nullopt) {
    ++transaction_;
    camera_.receive(encode({PtpType::kCommand, operation, transaction_, parameters, {}}), now_ns);
    if (data) camera_.receive(encode({PtpType::kData, operation, transaction_, {}, *data}), now_ns);
    Answer out;
    for (;;) {
      const auto container = next();
      if (!container || container->size() < kPtpHeaderBytes) return std::nullopt;
      EXPECT_EQ(number_at<std::uint32_t>(*container, 0), container->size());
      EXPECT_EQ(number_at<std::uint32_t>(*container, 8), transaction_);
      out.code = number_at<std::uint16_t>(*container, 6);
      if (number_at<std::uint16_t>(*container, 4) == static_cast<std::uint16_t>(PtpType::kResponse))
        return out;
      EXPECT_EQ(out.code, operation);
      out.data.assign(container->begin() + kPtpHeaderBytes, container->end());
    }
  }
  std::uint16_t set(std::uint16_t operation, std::uint16_t property, std::size_t width,
                    std::uint32_t value) {
    std::vector<std::byte> data;
    for (std::size_t i = 0; i < width; ++i) append(data, static_cast<std::uint8_t>(value >> 8 * i));
    const auto answer = ask(operation, {property}, data);
    return answer ? answer->code : 0;
  }
  /// The whole shutter button, down and up again.
  std::uint16_t press() {
    set(ptp::kControl, ptp::kHalfPress, 2, 2);
    const std::uint16_t code = set(ptp::kControl, ptp::kFullPress, 2, 2);
    set(ptp::kControl, ptp::kFullPress, 2, 1);
    set(ptp::kControl, ptp::kHalfPress, 2, 1);
    return code;
  }

  Nanoseconds now_ns = 0;

 private:
  std::optional<std::vector<std::byte>> next() {
    std::vector<std::byte> whole;
    constexpr std::size_t kRequest = 8 * PtpCameraFirmware::kPacketBytes;
    for (;;) {
      const auto part = camera_.bulk_in(kRequest, now_ns);
      if (!part) return whole.empty() ? std::nullopt : std::optional(whole);
      whole.insert(whole.end(), part->begin(), part->end());
      if (part->size() < kRequest) return whole;
    }
  }

  PtpCameraFirmware& camera_;
  std::uint32_t transaction_ = 0;
};

}  // namespace wheatstone
