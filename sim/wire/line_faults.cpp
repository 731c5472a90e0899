#include "sim/wire/line_faults.h"

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace wheatstone {

LineFaults::LineFaults(PtyPeer& peer, double probability, std::uint64_t seed)
    : peer_(peer), probability_(probability), random_(seed, 0) {
  if (!(probability >= 0 && probability <= 1))
    throw ArgumentError("a probability of faults is not in [0, 1]",
                        "use 0.01 for one in a hundred");
  peer_.spoil([this](std::string sent) { return spoil(std::move(sent)); });
}

LineFaults::~LineFaults() {
  peer_.spoil({});
}

std::string LineFaults::spoil(std::string sent) {
  const std::lock_guard lock(mutex_);
  if (line_ != Line::kGood) return "";
  if (random_.uniform() >= probability_) return sent;
  constexpr int kKinds = 5;
  switch (std::min(static_cast<int>(random_.uniform() * kKinds), kKinds - 1)) {
    case 0:
      happened_.emplace_back("fault: an answer is lost");
      return "";
    case 1:
      happened_.emplace_back("fault: an answer is cut short");
      return sent.substr(0, sent.size() / 2);
    case 2:
      happened_.emplace_back("fault: an answer is garbled");
      for (char& c : sent)
        if (random_.uniform() < 0.5)
          c = static_cast<char>(static_cast<int>(256 * random_.uniform()));
      return sent;
    case 3:
      line_ = Line::kToFallSilent;
      return "";
    default:
      line_ = Line::kToUnplug;
      return "";
  }
}

std::vector<std::string> LineFaults::tend(Nanoseconds now) {
  const auto in = [&](Duration d) { return now + static_cast<Nanoseconds>(1e9 * d.value()); };
  enum class Hand { kNone, kPull, kPutIn } hand = Hand::kNone;
  std::vector<std::string> happened;
  {
    const std::lock_guard lock(mutex_);
    if (line_ == Line::kToFallSilent) {
      line_ = Line::kSilent;
      until_ = in(kSilence);
      happened_.emplace_back("fault: silence");
    } else if (line_ == Line::kSilent && now >= until_) {
      line_ = Line::kGood;
      happened_.emplace_back("it answers again");
    } else if (line_ == Line::kToUnplug) {
      line_ = Line::kUnplugged;
      until_ = in(kUnplugged);
      hand = Hand::kPull;
      happened_.emplace_back("fault: the cable is pulled");
    } else if (line_ == Line::kUnplugged && now >= until_) {
      line_ = Line::kGood;
      hand = Hand::kPutIn;
    }
    happened = std::exchange(happened_, {});
  }
  // Not under the lock: the peer holds its own while it asks spoil().
  if (hand == Hand::kPull) peer_.unplug();
  if (hand == Hand::kPutIn) {
    peer_.plug_in();
    happened.push_back("the cable is in again: " + peer_.path().string());
  }
  return happened;
}

}  // namespace wheatstone
