// Every line of the table of faults of the stages, carried out.

#include "tests/contract/stage_faults.h"

#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/resources.h"
#include "tests/contract/stage_backends.h"
#include "tests/contract/warm_up.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr double kDeadlineS = 0.7;

/// Spoils what the device sends, or the device itself.
void inject(PtyPeer& peer, const std::string& fault) {
  static const std::string kLong(5000, 'a');
  static const std::map<std::string, std::string> kInstead = {
      {"garbage", "<Idle|MPos:0,a>\r\n"},
      {"over-long line", kLong},
      {"not ASCII", "\xc3\x28\xff\xfe\x80\r\n"},
      {"error 8", "error:8\r\n"},
      {"error 9", "error:9\r\n"},
      {"another place", "55\r\n"}};
  if (fault == "silence")
    peer.silence(true);
  else if (fault == "half a line")
    peer.cut_after(1);
  else if (fault == "unplugged")
    peer.unplug();
  else if (fault == "unplugged in an order")
    peer.unplug_after(3);
  else if (kInstead.contains(fault))
    peer.spoil([text = kInstead.at(fault)](const std::string&) { return text; });
}

template <class Call>
void expect_stage_fault(const FaultCase& fault, const Call& call) {
  expect_fault(fault, call, kDeadlineS);
}

/// Calls and injects the fault: as soon as it moves, if it is to move.
template <class Backend>
void carry_out(const FaultCase& fault, Backend& backend) {
  const std::string what = fault.fault, state = fault.state;
  PtyPeer& peer = backend.peer();
  LinearStage& stage = backend.stage();
  const auto act = [&] {
    if (what == "restart" || what == "limit switch")
      peer.with_firmware([&] { backend.disturb(what); });
    else
      inject(peer, what);
  };
  if (what == "switch broken") {
    expect_stage_fault(fault, [&](const Deadline& d) { stage.home(d); });
  } else if (state == "homing" || state == "moving") {
    if (state == "moving") stage.home(SteadyClock().in(Duration::of(20)));
    // These answer the very first order; all others come while it moves.
    const bool at_once = what == "error 8" || what == "error 9" ||
                         what == "unplugged in an order" || what == "answer to an earlier order";
    if (what == "answer to an earlier order")
      peer.spoil([text = backend.earlier_answer()](std::string sent) mutable {
        return std::exchange(text, "") + sent;
      });
    else if (at_once)
      backend.before_order(what, act);
    const std::jthread disturber([&, at_once](const std::stop_token& stop) {
      while (!stop.stop_requested() && !backend.moves_now())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (!at_once) act();
    });
    expect_stage_fault(fault, [&](const Deadline& d) {
      state == "homing" ? stage.home(d) : stage.move_to(Length::of(backend.kFarMm), d);
    });
  } else {
    stage.home(SteadyClock().in(Duration::of(20)));
    stage.move_to(Length::of(16.7), SteadyClock().in(Duration::of(20)));
    act();
    expect_stage_fault(fault, [&](const Deadline& d) { stage.position(d); });
  }
  EXPECT_EQ(to_string(stage.state()), fault.after);
  if (fault.error == Kind::kDisconnected) {
    expect_stage_fault(fault, [&](const Deadline& d) { stage.home(d); });  // it stays gone
    peer.plug_in();
    backend.close();
    EXPECT_EQ(backend.stage().home(SteadyClock().in(Duration::of(20))).value(), 0)
        << "a new object, under another path";
  } else if (std::string(fault.after) == "unknown") {
    EXPECT_THROW(stage.move_to(Length::of(1), SteadyClock().in(Duration::of(1))), DeviceError);
  }
}

class FaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up(); }
  ResourceWatch resources_{0.5};
};

struct GrblUnderTest : GrblBackend {
  using GrblBackend::GrblBackend;
  static constexpr double kFarMm = 160;  // well within the deadline
  void disturb(const std::string& what) {
    if (what == "limit switch")
      firmware().hit_limit();
    else
      firmware().restart();
  }
  static std::string earlier_answer() { return "ok\r\n"; }
  void before_order(const std::string&, const std::function<void()>& act) const { act(); }
};

class GrblFaults : public FaultTest {};

TEST_P(GrblFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  GrblFirmware::Options options;
  options.switch_works[0] = what != "switch broken";
  if (what == "wrong firmware") options.version = "0.9j";
  GrblUnderTest backend(options);
  if (std::string(fault.state) != "opening") {
    if (what == "error 8" && std::string(fault.state) == "homing") {
      backend.stage();
      // The first answers belong to the reset before.
      backend.peer().spoil(
          [](std::string sent) { return sent == "ok\r\n" ? std::string("error:8\r\n") : sent; });
      expect_stage_fault(fault, [&](const Deadline& d) { backend.stage().home(d); });
      EXPECT_EQ(to_string(backend.stage().state()), fault.after);
      return;
    }
    carry_out(fault, backend);
    if (fault.error != Kind::kDisconnected) {
      // Whatever went wrong, it does not go on moving.
      for (int i = 0; i < 500 && backend.moves_now(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      EXPECT_FALSE(backend.moves_now());
    }
    return;
  }
  const TemporaryFolder folder;
  std::filesystem::path port = backend.peer().path();
  std::unique_ptr<SerialPort> other;
  backend.peer().with_firmware([&] {
    if (what == "reports inches") backend.firmware().set(13, 1);
    if (what == "homing off") backend.firmware().set(22, 0);
    if (what == "soft limits off") backend.firmware().set(20, 0);
    if (what == "no machine position") backend.firmware().set(10, 0);
    if (what == "short travel") backend.firmware().set(130, 100);
  });
  if (what == "in use") other = std::make_unique<SerialPort>("another program", port, 115200);
  if (what == "not there") port = folder.path / "none";
  if (what == "no serial line") {
    port = folder.path / "port";
    std::ofstream(port) << "x";
  }
  inject(backend.peer(), what);
  expect_stage_fault(fault, [&](const Deadline& d) {
    GrblRail(std::make_shared<GrblController>(GrblSettings{port, 115200, nullptr}, d),
             GrblAxisSettings{0, 167});
  });
}

INSTANTIATE_TEST_SUITE_P(Stages, GrblFaults, ::testing::ValuesIn(kGrblFaults),
                         [](const ::testing::TestParamInfo<FaultCase>& fault) {
                           return test_name(fault.param);
                         });

struct ArduinoUnderTest : ArduinoBackend {
  using ArduinoBackend::ArduinoBackend;
  static constexpr double kFarMm = 120;  // well within the deadline
  void disturb(const std::string&) { firmware().restart(); }
  static std::string earlier_answer() { return "42\r\n"; }
  void before_order(const std::string&, const std::function<void()>& act) const { act(); }
};

class ArduinoGantryFaults : public FaultTest {};

TEST_P(ArduinoGantryFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  ArduinoUnderTest backend({5000, what != "switch broken"});
  if (state == "homing" && what != "switch broken") {
    // In silence: what is sent wrongly can only be seen in its answers afterwards.
    LinearStage& stage = backend.stage();
    inject(backend.peer(), what);
    expect_stage_fault(fault, [&](const Deadline& d) { stage.home(d); });
    EXPECT_EQ(to_string(stage.state()), fault.after);
    return;
  }
  if (state != "opening") {
    carry_out(fault, backend);
    return;
  }
  const TemporaryFolder folder;
  ArduinoGantrySettings settings;
  settings.port = backend.peer().path();
  std::unique_ptr<SerialPort> other;
  if (what == "in use")
    other = std::make_unique<SerialPort>("another program", settings.port, 9600);
  if (what == "not there") settings.port = folder.path / "none";
  if (what == "no serial line") {
    settings.port = folder.path / "port";
    std::ofstream(settings.port) << "x";
  }
  inject(backend.peer(), what);
  expect_stage_fault(fault, [&](const Deadline&) { ArduinoGantry{settings}; });
}

INSTANTIATE_TEST_SUITE_P(Stages, ArduinoGantryFaults, ::testing::ValuesIn(kArduinoGantryFaults),
                         [](const ::testing::TestParamInfo<FaultCase>& fault) {
                           return test_name(fault.param);
                         });

class SimulatedStageFaults : public FaultTest {};

TEST_P(SimulatedStageFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string state = fault.state;
  TwinStageBackend backend;
  LinearStage& stage = backend.stage();
  const auto soon = [&] { return backend.clock().in(Duration::of(30)); };
  if (state != "homing") stage.home(soon());
  const double before = backend.truth_mm();
  arm(backend.world().faults, "stage", fault);
  expect_stage_fault(fault, [&](const Deadline&) {
    if (state == "homing")
      stage.home(soon());
    else if (state == "moving")
      stage.move_to(Length::of(50), soon());
    else
      stage.position(soon());
  });
  EXPECT_EQ(to_string(stage.state()), fault.after);
  EXPECT_EQ(backend.truth_mm(), before) << "it stands";
}

INSTANTIATE_TEST_SUITE_P(Stages, SimulatedStageFaults, ::testing::ValuesIn(kSimulatedStageFaults),
                         [](const ::testing::TestParamInfo<FaultCase>& fault) {
                           return test_name(fault.param);
                         });

}  // namespace
}  // namespace wheatstone
