#pragma once
// The messages of the Picture Transfer Protocol over USB (PIMA 15740, USB still image class 1.0,
// section 7).

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

inline constexpr std::size_t kPtpHeaderBytes = 12;
inline constexpr std::size_t kPtpParameters = 5;

enum class PtpType : std::uint16_t { kCommand = 1, kData = 2, kResponse = 3, kEvent = 4 };

struct PtpContainer {
  PtpType type = PtpType::kCommand;
  std::uint16_t code = 0;
  std::uint32_t transaction = 0;
  std::vector<std::uint32_t> parameters;  // at most 5; not of data
  std::vector<std::byte> data;            // of data only
};
std::vector<std::byte> encode(const PtpContainer&);

/// Puts together what a host sends, transfer by transfer.
class PtpAssembler {
 public:
  enum class State { kWaiting, kWhole, kMalformed };

  /// kWhole: container() is there. kMalformed: a length that cannot be, a type that a host does not
  /// send, more than 64 KiB of data, bytes behind the end; what came so far is forgotten. Never
  /// throws.
  State feed(std::span<const std::byte> transfer);
  const PtpContainer& container() const { return container_; }
  void clear() { bytes_.clear(); }

 private:
  std::vector<std::byte> bytes_;
  PtpContainer container_;
};

/// Text as PTP writes it: a count with the terminator, then UTF-16. Characters beyond ASCII become
/// '?', and what is longer than 254 is cut.
void append_ptp_text(std::vector<std::byte>&, const std::string&);
void append_ptp_codes(std::vector<std::byte>&, const std::vector<std::uint16_t>&);

}  // namespace wheatstone
