#include "sim/wire/line_faults.h"

#include <gmock/gmock.h>

#include <set>

#include "core/error.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {
namespace {

/// Answers each line with a line.
class Echo final : public SerialFirmware {
 public:
  void receive(std::string_view bytes, Nanoseconds) override {
    for (const char c : bytes)
      if (c == '\n') out_ += kAnswer;
  }
  std::string run(Nanoseconds) override { return std::exchange(out_, {}); }
  Nanoseconds next_event() const override { return kNever; }

  static constexpr const char* kAnswer = "a rather long answer\n";

 private:
  std::string out_;
};

struct Bed {
  std::string ask(const SteadyClock& clock = {}) {
    if (!port) port = std::make_unique<SerialPort>("the echo", peer.path(), 115200);
    port->discard_input();
    port->write("hello\n", clock.in(Duration::of(1)));
    return port->read_line('\n', 100, clock.in(Duration::of(0.05)));
  }
  std::vector<std::string> tend(double seconds_later) {
    now += static_cast<Nanoseconds>(1e9 * seconds_later);
    return faults.tend(now);
  }

  Echo echo;
  PtyPeer peer{echo};
  LineFaults faults;
  std::unique_ptr<SerialPort> port{};
  Nanoseconds now = 0;

  Bed(double probability, std::uint64_t seed) : faults(peer, probability, seed) {}
};

TEST(LineFaults, EveryKindHappensAndIsTold) {
  Bed bed(1, 1);
  std::set<std::string> told;
  for (int i = 0; i < 100 && told.size() < 7; ++i) {
    try {
      EXPECT_NE(bed.ask(), "a rather long answer") << "no answer is spared";
    } catch (const DeviceError& e) {
      EXPECT_THAT(e.kind(),
                  ::testing::AnyOf(DeviceError::Kind::kTimeout, DeviceError::Kind::kDisconnected,
                                   DeviceError::Kind::kProtocol));
      if (e.kind() == DeviceError::Kind::kDisconnected) {
        bed.port.reset();
        for (const std::string& line : bed.tend(2.5))
          told.insert(line.substr(0, line.find(':', 6)));
      }
    }
    for (const double later : {0.1, 3.5})
      for (const std::string& line : bed.tend(later)) {
        told.insert(line.substr(0, line.find(':', 6)));
        if (line.starts_with("fault: the cable")) bed.port.reset();
      }
  }
  EXPECT_THAT(told, ::testing::UnorderedElementsAre(
                        "fault: an answer is lost", "fault: an answer is cut short",
                        "fault: an answer is garbled", "fault: silence", "it answers again",
                        "fault: the cable is pulled", "the cable is in again"));
}

TEST(LineFaults, WithoutAnyNothingHappens) {
  Bed bed(0, 1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(bed.ask(), "a rather long answer");
  EXPECT_THAT(bed.tend(10), ::testing::IsEmpty());
}

TEST(LineFaults, ProbabilitiesThatAreNone) {
  Echo echo;
  PtyPeer peer(echo);
  for (const double p : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(LineFaults(peer, p, 1), ArgumentError) << p;
}

}  // namespace
}  // namespace wheatstone
