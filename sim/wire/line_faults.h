#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/random.h"
#include "sim/wire/pty_peer.h"

namespace wheatstone {

/// What goes wrong at serial lines, at random, for training: an answer is lost, cut short or
/// garbled, the device says nothing for a while, or its cable is pulled and is soon in again, under
/// another path. tend() and the peer may be used from two threads.
class LineFaults {
 public:
  static constexpr Duration kSilence = Duration::of(3), kUnplugged = Duration::of(2);

  /// Of everything that the peer sends at once a fault befalls one in 1 / `probability`. Throws
  /// ArgumentError unless 0 <= probability <= 1. `peer` outlives this object.
  LineFaults(PtyPeer& peer, double probability, std::uint64_t seed);
  ~LineFaults();
  LineFaults(const LineFaults&) = delete;
  LineFaults& operator=(const LineFaults&) = delete;

  /// Pulls cables, puts them in again, ends silences; to be called some times a second. Returns
  /// what happened since the last call, for people.
  std::vector<std::string> tend(Nanoseconds now);

 private:
  enum class Line { kGood, kToFallSilent, kSilent, kToUnplug, kUnplugged };

  std::string spoil(std::string sent);

  PtyPeer& peer_;
  const double probability_;
  std::mutex mutex_;  // of all below
  RandomStream random_;
  Line line_ = Line::kGood;
  Nanoseconds until_ = 0;  // when a silence ends, or the cable is put in
  std::vector<std::string> happened_;
};

}  // namespace wheatstone
