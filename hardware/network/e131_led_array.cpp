#include "hardware/network/e131_led_array.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr int kTerminations = 3;            // E1.31, 6.2.6
constexpr std::uint8_t kOldSequences = 20;  // E1.31, 6.7.2: so many behind are dropped

E131Settings checked(const E131Settings& s) {
  require_response(s.response_gamma, s.max_mean_drive);
  if (s.leds_per_universe < 1 || s.leds_per_universe > kE131Slots / 3)
    throw ArgumentError(fmt::format("{} LEDs do not fit a universe", s.leds_per_universe),
                        "use 1 to 170");
  if (s.priority < 0 || s.priority > 200)
    throw ArgumentError(fmt::format("{} is no priority", s.priority), "use 0 to 200");
  if (!(s.keep_alive.value() >= 0.01 && s.keep_alive.value() <= 2.4))
    throw ArgumentError(
        fmt::format("repeating frames every {} s keeps no stream alive", s.keep_alive.value()),
        "use 0.01 to 2.4");
  return s;
}

/// The same for the same machine and universes.
E131Source source_for(const E131Settings& s) {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  const std::string name = fmt::format("Wheatstone on {}", host);
  E131Source source{{}, name, s.priority};
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : fmt::format("{} {}", name, s.first_universe))
    hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  for (std::size_t i = 0; i < source.id.size(); ++i) {
    source.id[i] = static_cast<std::uint8_t>(hash >> 56);
    hash *= 0x5851f42d4c957f2d;
  }
  source.id[6] = static_cast<std::uint8_t>(0x80 | (source.id[6] & 0x0f));  // RFC 9562, version 8
  source.id[8] = static_cast<std::uint8_t>(0x80 | (source.id[8] & 0x3f));
  return source;
}

}  // namespace

E131Universes e131_universes(const E131Settings& s) {
  const int leds = s.mapping.rows * s.mapping.columns;
  const int count = (leds + s.leds_per_universe - 1) / s.leds_per_universe;
  const int sync = s.sync_universe == 0 && count > 1 ? s.first_universe + count : s.sync_universe;
  if (s.first_universe < 1 || std::max(s.first_universe + count - 1, sync) > kE131LastUniverse)
    throw ArgumentError(fmt::format("{} universes from {} on are not all in [1, {}]", count,
                                    s.first_universe, kE131LastUniverse),
                        "use a lower first universe");
  if (sync < 0 || (sync >= s.first_universe && sync < s.first_universe + count))
    throw ArgumentError(fmt::format("universe {} cannot synchronise", sync),
                        "use one that carries no LEDs");
  return {count, sync};
}

E131LedArray::E131LedArray(const E131Settings& settings)
    : settings_(checked(settings)),
      place_of_led_(places_on_wire(settings.mapping)),
      universes_(e131_universes(settings)),
      source_(source_for(settings)) {
  for (int i = 0; i < universes_.count + (universes_.sync ? 1 : 0); ++i) {
    const int universe = i < universes_.count ? settings_.first_universe + i : universes_.sync;
    channels_.emplace_back(
        "the E1.31 LED array",
        settings_.address.empty() ? e131_multicast_address(universe) : settings_.address,
        settings_.port, settings_.from);
  }
  sequences_.resize(channels_.size());
  black_ = datagrams({cv::Mat3f::zeros(rows(), columns())});
  if (universes_.sync) sync_ = e131_sync(source_, universes_.sync);
  // Twice, so far apart that one of them is not behind what a receiver still has of us.
  for (int i = 0; i < 2; ++i) {
    if (const int error = send(black_))
      throw DeviceError(Kind::kNotFound,
                        fmt::format("no E1.31 LED array is at {}:{} ({})", settings_.address,
                                    settings_.port, std::strerror(error)),
                        "switch it on, or correct its address");
    if (i == 0)
      for (std::uint8_t& s : sequences_) s = static_cast<std::uint8_t>(s + kOldSequences - 1);
  }
  repeater_ = std::jthread([this](const std::stop_token& stop) { repeat(stop); });
}

E131LedArray::~E131LedArray() {
  repeater_.request_stop();
  repeater_.join();
  all_off();
  terminate();
}

DeviceIdentity E131LedArray::identity() const {
  return {"e131",
          fmt::format("universes {} to {}", settings_.first_universe,
                      settings_.first_universe + universes_.count - 1),
          "", "",
          fmt::format("udp {}:{}", settings_.address.empty() ? "multicast" : settings_.address,
                      settings_.port)};
}

E131LedArray::Frame E131LedArray::datagrams(const LedFrame& frame) const {
  const auto leds = place_of_led_.size(),
             each = static_cast<std::size_t>(settings_.leds_per_universe);
  std::vector<std::uint8_t> codes(3 * leds);
  std::size_t led = 0;
  for (const cv::Vec3f& rgb : frame.drive) {
    const auto place = static_cast<std::size_t>(place_of_led_[led++]);
    for (std::size_t c = 0; c < 3; ++c)
      codes[3 * place + c] = static_cast<std::uint8_t>(
          std::lround(255 * std::pow(static_cast<double>(rgb[static_cast<int>(c)]),
                                     1 / settings_.response_gamma[c])));
  }
  Frame out;
  for (int u = 0; u < universes_.count; ++u) {
    const std::size_t first = static_cast<std::size_t>(u) * each,
                      count = std::min(each, leds - first);
    out.push_back(e131_data(source_, settings_.first_universe + u, universes_.sync,
                            std::span(codes).subspan(3 * first, 3 * count)));
  }
  return out;
}

int E131LedArray::send_one(std::size_t channel, std::vector<std::uint8_t>& datagram,
                           std::size_t sequence_at) noexcept {
  datagram[sequence_at] = sequences_[channel];
  const int error = channels_[channel].send(datagram);
  if (error == 0) ++sequences_[channel];
  return error;
}

/// All universes, and then the word to show them. Pre: mutex_.
int E131LedArray::send(Frame& frame) noexcept {
  for (std::size_t u = 0; u < frame.size(); ++u)
    if (const int error = send_one(u, frame[u], kE131DataSequenceAt)) return error;
  if (universes_.sync)
    if (const int error = send_one(channels_.size() - 1, sync_, kE131SyncSequenceAt)) return error;
  for (UdpSender& channel : channels_)
    if (const int error = channel.take_error()) return error;
  return 0;
}

void E131LedArray::fail_lost() {
  throw DeviceError(Kind::kDisconnected,
                    fmt::format("the E1.31 LED array at {}:{} is no longer there ({})",
                                settings_.address, settings_.port, std::strerror(lost_)),
                    "switch it on, connect the network and open it again");
}

void E131LedArray::set_frame(const LedFrame& frame, Deadline deadline) {
  constexpr Nanoseconds kNapNs = 1'000'000;
  require_valid(*this, frame);
  Frame next = datagrams(frame);
  SteadyClock clock;
  std::unique_lock lock(mutex_);
  for (const std::uint32_t switched_off = switched_off_;;) {
    if (lost_) fail_lost();
    if (switched_off_ != switched_off)
      throw DeviceError(Kind::kRefused, "the LEDs were switched off before the frame showed",
                        "send it again");
    if (deadline.cancel.stop_requested())
      throw Cancelled("the E1.31 LED array: stopped on request");
    if (clock.now_ns() >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout, "the network takes nothing for the E1.31 LED array",
                        "check the network");
    const int error = send(next);
    if (error == 0) break;
    if (error != EAGAIN && error != ENOBUFS) {
      lost_ = error;
      fail_lost();
    }
    lock.unlock();
    clock.wait_until(clock.now_ns() + kNapNs);
    lock.lock();
  }
  lit_ = std::move(next);
  dark_ = false;
}

void E131LedArray::all_off() noexcept {
  const std::lock_guard lock(mutex_);
  ++switched_off_;
  dark_ = true;
  send(black_);
}

void E131LedArray::repeat(const std::stop_token& stop) {
  const auto period = std::chrono::duration<double>(settings_.keep_alive.value());
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    never_.wait_for(lock, stop, period, [] { return false; });
    if (stop.stop_requested()) return;
    const int error = lost_ ? 0 : send(dark_ ? black_ : lit_);
    if (error && error != EAGAIN && error != ENOBUFS) lost_ = error;
  }
}

void E131LedArray::terminate() noexcept {
  const std::lock_guard lock(mutex_);
  for (auto& datagram : black_) datagram[kE131OptionsAt] |= kE131Terminated;
  for (int i = 0; i < kTerminations; ++i)
    for (std::size_t u = 0; u < black_.size(); ++u) send_one(u, black_[u], kE131DataSequenceAt);
}

}  // namespace wheatstone
