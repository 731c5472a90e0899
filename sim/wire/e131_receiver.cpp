#include "sim/wire/e131_receiver.h"

#include <algorithm>
#include <string_view>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr std::string_view kHead("\0\x10\0\0ASC-E1.17\0\0\0", 16);
constexpr std::size_t kDataBytes = 126, kSyncBytes = 49, kLedsPerUniverse = 170;
constexpr std::size_t kLongest = 638;
constexpr double kStep = 0.05;  // streams are given up so exactly

std::uint32_t number(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t count) {
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < count; ++i) n = n << 8 | bytes[at + i];
  return n;
}

/// The layer that begins at `at` says that it goes to the end.
bool has_length(std::span<const std::uint8_t> bytes, std::size_t at) {
  return number(bytes, at, 2) == (0x7000 | (bytes.size() - at));
}

}  // namespace

std::optional<E131Message> parse_e131(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kSyncBytes || bytes.size() > kLongest ||
      !std::equal(kHead.begin(), kHead.end(), bytes.begin(),
                  [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; }) ||
      !has_length(bytes, 16) || !has_length(bytes, 38))
    return std::nullopt;
  E131Message m;
  std::copy_n(bytes.begin() + 22, m.source.size(), m.source.begin());
  const std::uint32_t root = number(bytes, 18, 4), framing = number(bytes, 40, 4);
  if (root == 8 && framing == 1 && bytes.size() == kSyncBytes) {
    m.kind = E131Message::Kind::kSync;
    m.sequence = bytes[44];
    m.sync_universe = static_cast<std::uint16_t>(number(bytes, 45, 2));
    return m;
  }
  if (root != 4 || framing != 2 || bytes.size() < kDataBytes || !has_length(bytes, 115) ||
      number(bytes, 117, 2) != 0x02a1 || number(bytes, 119, 4) != 1 ||
      number(bytes, 123, 2) != bytes.size() - kDataBytes + 1 || bytes[125] != 0)
    return std::nullopt;
  m.priority = bytes[108];
  m.sync_universe = static_cast<std::uint16_t>(number(bytes, 109, 2));
  m.sequence = bytes[111];
  m.terminated = bytes[112] & 0x40;
  m.universe = static_cast<std::uint16_t>(number(bytes, 113, 2));
  m.slots.assign(bytes.begin() + kDataBytes, bytes.end());
  return m;
}

void E131Node::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) {
  const auto m = parse_e131(bytes);
  if (!m) {
    ++refused_;
    return;
  }
  if (m->kind == E131Message::Kind::kSync) {
    bool any = false;
    for (Universe& u : universes_)
      if (u.alive && u.sync_universe == m->sync_universe && !u.waiting.empty()) {
        u.slots = std::exchange(u.waiting, {});
        any = true;
      }
    if (any) show();
    return;
  }
  const int index = m->universe - first_;
  if (index < 0 || index >= static_cast<int>(universes_.size())) return;
  Universe& u = universes_[static_cast<std::size_t>(index)];
  if (u.alive && u.source != m->source) return;
  const int ahead = static_cast<std::int8_t>(static_cast<std::uint8_t>(m->sequence - u.sequence));
  if (u.alive && ahead <= 0 && ahead > -20) {
    ++behind_;
    return;
  }
  u.source = m->source;
  u.sequence = m->sequence;
  u.last_ns = now;
  u.sync_universe = m->sync_universe;
  if (m->terminated) {
    ++terminations_;
    u = {};
    show();
    return;
  }
  u.alive = true;
  (m->sync_universe ? u.waiting : u.slots) = m->slots;
  if (!m->sync_universe) show();
}

void E131Node::run(Nanoseconds now) {
  bool lost = false;
  for (Universe& u : universes_)
    if (u.alive && now - u.last_ns > kLossNs) {
      u = {};
      lost = true;
    }
  if (lost) show();
}

int E131Node::streams() const {
  return static_cast<int>(std::count_if(universes_.begin(), universes_.end(),
                                        [](const Universe& u) { return u.alive; }));
}

void E131Node::show() {
  std::vector<LedCeiling::Rgb> drive(kLedsPerUniverse * universes_.size());
  for (std::size_t u = 0; u < universes_.size(); ++u) {
    const std::vector<std::uint8_t>& slots = universes_[u].slots;
    for (std::size_t i = 0; i < std::min(slots.size(), 3 * kLedsPerUniverse); ++i)
      drive[u * kLedsPerUniverse + i / 3][i % 3] = slots[i] / 255.0;
  }
  ++shown_;
  ceiling_.drive(drive);
}

E131Receiver::E131Receiver(LedCeiling& ceiling, int first_universe, int universes)
    : node_(ceiling, first_universe, universes),
      socket_(std::make_unique<UdpReceiver>("the emulated E1.31 controller", "127.0.0.1", 0)),
      port_(socket_->port()),
      thread_([this](const std::stop_token& stop) { listen(stop); }) {}

E131Receiver::~E131Receiver() {
  switch_off();
}

void E131Receiver::with_node(const std::function<void(E131Node&)>& act) {
  const std::lock_guard lock(mutex_);
  act(node_);
}

void E131Receiver::switch_off() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  socket_.reset();
}

void E131Receiver::filter(std::function<bool(std::span<const std::uint8_t>)> keep) {
  const std::lock_guard lock(mutex_);
  filter_ = std::move(keep);
}

void E131Receiver::listen(const std::stop_token& stop) {
  const SteadyClock clock;
  while (!stop.stop_requested()) {
    std::vector<std::string> datagrams;
    try {
      datagrams = socket_->receive(kLongest, clock.in(Duration::of(kStep), stop));
    } catch (const Error&) {  // nothing came, or it is to end
    }
    const std::lock_guard lock(mutex_);
    for (const std::string& d : datagrams) {
      const std::span bytes(reinterpret_cast<const std::uint8_t*>(d.data()), d.size());
      if (!filter_ || filter_(bytes)) node_.receive(bytes, clock.now_ns());
    }
    node_.run(clock.now_ns());
  }
}

}  // namespace wheatstone
