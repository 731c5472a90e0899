// What every head tracker promises, whatever it is made of; and every line of the table of their
// faults, carried out.

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <fstream>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/head_tracker_backends.h"
#include "tests/contract/head_tracker_faults.h"
#include "tests/contract/resources.h"
#include "tests/contract/warm_up.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr double kPeriodS = 1 / kTrackerSamplesPerS;
constexpr double kLateS = 0.15;  // that a busy machine may be

double seconds(Nanoseconds t) {
  return 1e-9 * static_cast<double>(t);
}

class WithResources {
 protected:
  ResourceWatch resources_{1.0};  // a world takes its time
};

struct Maker {
  const char* name;
  std::unique_ptr<HeadTrackerBackend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class HeadTrackerContract : public ::testing::TestWithParam<Maker>, protected WithResources {
 protected:
  static void SetUpTestSuite() { warm_up(); }
  HeadTracker& tracker() { return backend_->tracker(); }
  Deadline soon() { return backend_->clock().in(Duration::of(2)); }
  EyeCentres next() { return tracker().next(soon()); }

  std::unique_ptr<HeadTrackerBackend> backend_ = GetParam().make();
};

TEST_P(HeadTrackerContract, SaysWhoItIs) {
  next();
  EXPECT_FALSE(tracker().identity().driver.empty());
  EXPECT_EQ(tracker().identity().serial, "SIM-TRACKER");
}

TEST_P(HeadTrackerContract, SeesTheEyesWhereTheyAreAndBlinksAsNone) {
  const SwayingHead head(7);
  int seen = 0, closed = 0;
  for (int i = 0; i < 252; ++i) {  // a little more than four seconds: there is a blink
    const EyeCentres sample = next();
    EXPECT_EQ(sample.eyes[0].has_value(), sample.eyes[1].has_value());
    ++(sample.eyes[0] ? seen : closed);
    for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
      const auto& e = sample.eyes[eye == Eye::kLeft ? 0 : 1];
      if (!e) continue;
      const Eigen::Vector3d error =
          e->p_rsb_mm - head.eye_rsb_mm(eye, sample.time_ns - backend_->epoch_ns());
      EXPECT_LT(std::abs(error.x()), 6 * kTrackerSigmaMm + 2 * kLateS);
      EXPECT_LT(std::abs(error.y()), 6 * kTrackerSigmaMm + 2 * kLateS);
      EXPECT_LT(std::abs(error.z()), 6 * kTrackerSigmaDepthMm + 2 * kLateS);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(e->covariance_mm2)
                    .eigenvalues()
                    .minCoeff(),
                0);
      EXPECT_GT(e->confidence, 0);
      EXPECT_LE(e->confidence, 1);
    }
  }
  EXPECT_GT(closed, 0);
  EXPECT_GT(seen, 10 * closed);
}

TEST_P(HeadTrackerContract, TimesGoForwardAndAreOfThePast) {
  EyeCentres last = next();
  for (int i = 0; i < 30; ++i) {
    const EyeCentres sample = next();
    const double step_s = seconds(sample.time_ns - last.time_ns);
    EXPECT_GT(step_s, 0);
    EXPECT_LT(step_s, kPeriodS + kLateS);
    EXPECT_LE(sample.time_ns, backend_->clock().now_ns());
    last = sample;
  }
}

TEST_P(HeadTrackerContract, HandsOutTheNewestSampleOnce) {
  next();
  backend_->clock().wait_until(backend_->clock().in(Duration::of(0.5)).at_ns);
  const EyeCentres newest = next();
  EXPECT_LT(seconds(backend_->clock().now_ns() - newest.time_ns), kPeriodS + kLateS);
  EXPECT_GT(next().time_ns, newest.time_ns);
}

TEST_P(HeadTrackerContract, KeepsDeadlinesAndStopsOnRequest) {
  next();
  EXPECT_EQ(kind_of([&] { tracker().next({backend_->clock().now_ns()}); }), Kind::kTimeout);
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(tracker().next({soon().at_ns, asked.get_token()}), Cancelled);
  next();
}

TEST_P(HeadTrackerContract, StaysGoneOnceItIsGone) {
  next();
  if (!backend_->unplug()) return;  // datagrams have no line that could be cut
  EXPECT_EQ(kind_of([&] {
              for (int i = 0; i < 100; ++i) next();
            }),
            Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { next(); }), Kind::kDisconnected);
}

template <class Backend>
std::unique_ptr<HeadTrackerBackend> make() {
  return std::make_unique<Backend>();
}

const Maker kMakers[] = {{"Twin", make<TwinHeadTrackerBackend>},
                         {"Serial", make<SerialHeadTrackerBackend>},
                         {"Udp", make<UdpHeadTrackerBackend>}};

INSTANTIATE_TEST_SUITE_P(Trackers, HeadTrackerContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

class FaultTest : public ::testing::TestWithParam<FaultCase>, protected WithResources {
 protected:
  static void SetUpTestSuite() { warm_up(); }
};

Deadline soon() {
  return SteadyClock().in(Duration::of(2));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// What becomes of what is sent.
std::function<std::string(std::string)> spoiler(const std::string& fault) {
  const auto replace = [](const char* from, const char* to) {
    return [=](const std::string& sent) { return replaced(sent, from, to); };
  };
  if (fault == "garbage") return [](const std::string&) { return "{\"n\": [}\n"; };
  if (fault == "over-long line") return [](const std::string&) { return std::string(5000, 'a'); };
  if (fault == "not ASCII") return [](const std::string&) { return "\xc3\x28\xff\xfe\x80\n"; };
  if (fault == "half a datagram") return [](std::string s) { return s.substr(0, s.size() / 2); };
  if (fault == "another version") return replace("\"wheatstone_eyes\":1", "\"wheatstone_eyes\":2");
  if (fault == "impossible place") return replace("\"p_rsb_mm\":[1", "\"p_rsb_mm\":[1000000");
  if (fault == "another tracker") return replace("SIM-TRACKER", "SOMEBODY");
  if (fault == "old samples")
    return [first = std::string()](const std::string& sent) mutable {
      if (first.empty()) first = sent;
      return first;
    };
  return {};
}

/// Has a sample first, then the fault, then, after it, samples again.
template <class Backend>
void run_into(const FaultCase& fault, Backend& backend) {
  const std::string what = fault.fault;
  HeadTracker& tracker = backend.tracker();
  // Datagrams cannot tell who they are from: there is none first.
  if (what != "another sender") tracker.next(soon());
  if (what == "silence") backend.peer().silence(true);
  if (what == "unplugged") backend.unplug();
  backend.peer().spoil(spoiler(what));
  if constexpr (std::is_same_v<Backend, SerialHeadTrackerBackend>)
    if (what == "half a line") backend.peer().cut_after(20);
  if (what == "old samples") tracker.next(soon());
  std::jthread hand;
  if (what == "unplugged while waiting") {
    backend.peer().silence(true);
    hand = std::jthread([&] {
      SteadyClock().wait_until(SteadyClock().in(Duration::of(0.1)).at_ns);
      backend.unplug();
    });
  }
  expect_fault(fault, [&](const Deadline& d) {
    for (int i = 0; i < 10; ++i) tracker.next(d);  // good samples that were on their way
    if (fault.error == kTimeout)
      for (;;) tracker.next(d);
  });
}

class SerialHeadTrackerFaults : public FaultTest {};

TEST_P(SerialHeadTrackerFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  SerialHeadTrackerBackend backend;
  if (std::string(fault.state) == "opening") {
    const TemporaryFolder folder;
    SerialHeadTrackerSettings settings{backend.peer().path(), 115200, ""};
    std::unique_ptr<SerialPort> other;
    if (what == "in use")
      other = std::make_unique<SerialPort>("another program", settings.line, 115200);
    if (what == "not there") settings.line = folder.path / "none";
    if (what == "no serial line") {
      settings.line = folder.path / "file";
      std::ofstream(settings.line) << "x";
    }
    expect_fault(fault, [&](const Deadline&) { SerialHeadTracker{settings}; });
    return;
  }
  run_into(fault, backend);
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { backend.tracker().next(soon()); }), Kind::kDisconnected);
    backend.close();
    backend.peer().silence(false);
    backend.peer().plug_in();  // under another path
  }
  backend.peer().spoil({});
  backend.peer().silence(false);
  for (int i = 0; i < 5 && kind_of([&] { backend.tracker().next(soon()); }); ++i) continue;
  EXPECT_EQ(kind_of([&] { backend.tracker().next(soon()); }), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Trackers, SerialHeadTrackerFaults,
                         ::testing::ValuesIn(kSerialHeadTrackerFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class UdpHeadTrackerFaults : public FaultTest {};

TEST_P(UdpHeadTrackerFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  UdpHeadTrackerBackend backend(0, what == "another sender" ? "127.0.0.9" : "");
  if (what == "port in use" || what == "address of another machine") {
    UdpHeadTrackerSettings settings;
    settings.port = backend.port();
    if (what != "port in use") settings.address = "192.0.2.1";
    expect_fault(fault, [&](const Deadline&) { UdpHeadTracker{settings}; });
    return;
  }
  run_into(fault, backend);
  if (what == "another sender") return;
  backend.peer().spoil({});
  backend.peer().silence(false);
  for (int i = 0; i < 5 && kind_of([&] { backend.tracker().next(soon()); }); ++i) continue;
  EXPECT_EQ(kind_of([&] { backend.tracker().next(soon()); }), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Trackers, UdpHeadTrackerFaults, ::testing::ValuesIn(kUdpHeadTrackerFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedHeadTrackerFaults : public FaultTest {};

TEST_P(SimulatedHeadTrackerFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  TwinHeadTrackerBackend backend;
  const auto in_time = [&] { return backend.clock().in(Duration::of(1)); };
  backend.tracker().next(in_time());
  arm(backend.world().faults, "tracker", fault);
  expect_fault(fault, [&](const Deadline&) { backend.tracker().next(in_time()); });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { backend.tracker().next(in_time()); }), Kind::kDisconnected);
    backend.world().faults.reconnect("tracker");
  }
  backend.tracker().next(in_time());
}

INSTANTIATE_TEST_SUITE_P(Trackers, SimulatedHeadTrackerFaults,
                         ::testing::ValuesIn(kSimulatedHeadTrackerFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class HeadTrackerOddities : public FaultTest {};

TEST_F(HeadTrackerOddities, SampleNumbersMayWrap) {
  UdpHeadTrackerBackend backend(0xfffffff0);
  Nanoseconds last = 0;
  for (int i = 0; i < 40; ++i) {
    const EyeCentres sample = backend.tracker().next(soon());
    EXPECT_GT(sample.time_ns, last);
    last = sample.time_ns;
  }
}

TEST_F(HeadTrackerOddities, AClockThatIsSetBackOrForwardDoesNotMoveTheSamples) {
  UdpHeadTrackerBackend backend;
  for (const Nanoseconds by :
       {Nanoseconds{0}, Nanoseconds{-500'000'000'000}, Nanoseconds{300'000'000'000}}) {
    backend.peer().with_firmware([&] { backend.firmware().step_clock(by); });
    for (int i = 0; i < 5; ++i) backend.tracker().next(soon());
    const Nanoseconds time_ns = backend.tracker().next(soon()).time_ns;
    const double age_s = seconds(SteadyClock().now_ns() - time_ns);
    EXPECT_GT(age_s, 0);
    EXPECT_LT(age_s, kLateS);
  }
}

TEST_F(HeadTrackerOddities, AStrayDatagramDoesNotHideAGoodOne) {
  UdpHeadTrackerBackend backend;
  backend.tracker().next(soon());
  for (int i = 0; i < 3; ++i) {
    backend.peer().send("nobody asked for this");
    SteadyClock().wait_until(SteadyClock().in(Duration::of(0.05)).at_ns);  // till good ones are in
    EXPECT_NO_THROW(backend.tracker().next(soon()));
  }
}

}  // namespace
}  // namespace wheatstone
