#include "sim/wire/photodiode_firmware.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "hardware/serial/photodiode_message.h"

namespace wheatstone {
namespace {

constexpr std::size_t kBlock = PhotodiodeBlock::kMostSamples;
constexpr Nanoseconds kLeadNs = 200'000;  // from the command to the first sample
constexpr std::size_t kLongestLine = 64;

}  // namespace

void PhotodiodeFirmware::receive(std::string_view bytes, Nanoseconds now) {
  for (const char c : bytes) {
    if (c == '\n')
      command(std::exchange(line_, {}), now);
    else if (line_.size() < kLongestLine)
      line_ += c;
  }
}

void PhotodiodeFirmware::command(const std::string& line, Nanoseconds now) {
  if (line == "ID") {
    answers_ += identity + "\n";
  } else if (line == "STOP") {
    samples_.clear();
    sent_ = 0;
    answers_ += "STOPPED\n";
  } else if (line.starts_with("TIME ")) {
    const unsigned long tag = std::strtoul(line.c_str() + 5, nullptr, 10);
    answers_ += fmt::format("TIME {} {}\n", refuse_time ? tag - 1 : tag, us(now));
  } else if (line.starts_with("RECORD ") && !refusal.empty()) {
    answers_ += refusal + "\n";
  } else if (line.starts_with("RECORD ") && !recording()) {
    const unsigned long count = std::strtoul(line.c_str() + 7, nullptr, 10);
    first_us += static_cast<std::uint32_t>(step_clock_us);
    start_ns_ = now + kLeadNs;
    samples_ = diode_.samples(count + static_cast<unsigned long>(extra_samples), recordings_++);
    sent_ = 0;
    block_ = 0;
    answers_ += fmt::format("RECORD {}\n", us(start_ns_));
  } else {
    answers_ += recording() ? "ERROR recording\n" : "ERROR unknown command\n";
  }
}

Nanoseconds PhotodiodeFirmware::block_done(std::size_t sent) const {
  const std::size_t end = std::min(sent + kBlock, samples_.size());
  return start_ns_ +
         static_cast<Nanoseconds>(1e9 * static_cast<double>(end) / kPhotodiodeSamplesPerS);
}

std::string PhotodiodeFirmware::run(Nanoseconds now) {
  std::string out = std::exchange(answers_, {});
  while (recording() && block_done(sent_) <= now && (stall_after < 0 || block_ <= stall_after)) {
    const auto begin = samples_.begin() + static_cast<std::ptrdiff_t>(sent_);
    const std::size_t n = std::min(kBlock, samples_.size() - sent_);
    if (block_ != lose_block)
      out += encode({static_cast<std::uint8_t>(block_), {begin, begin + static_cast<long>(n)}});
    sent_ += n;
    ++block_;
  }
  return out;
}

Nanoseconds PhotodiodeFirmware::next_event() const {
  const bool stalled = stall_after >= 0 && block_ > stall_after;
  return recording() && !stalled ? block_done(sent_) : kNever;
}

}  // namespace wheatstone
