// What every linear stage promises, whatever it is made of.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <thread>

#include "core/error.h"
#include "tests/contract/resources.h"
#include "tests/contract/stage_backends.h"
#include "tests/contract/warm_up.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

struct Maker {
  const char* name;
  std::unique_ptr<StageBackend> (*make)();
};

void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

template <class Call>
std::optional<Kind> kind_of(const Call& call) {
  try {
    call();
    return std::nullopt;
  } catch (const DeviceError& e) {
    return e.kind();
  }
}

class StageContract : public ::testing::TestWithParam<Maker> {
 protected:
  LinearStage& stage() { return backend_->stage(); }
  Deadline soon() { return backend_->clock().in(Duration::of(20)); }
  void home() { stage().home(soon()); }
  double tolerance_mm() {
    return stage().resolution().value() / 2 + backend_->settling_mm() + 1e-9;
  }

  std::jthread when_it_moves(const std::function<void()>& act) {
    if (!backend_->takes_real_time()) return {};
    return std::jthread([this, act](const std::stop_token& stop) {
      while (!stop.stop_requested() && !backend_->moves_now())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      act();
    });
  }

  static void SetUpTestSuite() { warm_up(); }

  ResourceWatch resources_{0.5};  // a world takes its time
  std::unique_ptr<StageBackend> backend_ = GetParam().make();
};

TEST_P(StageContract, SaysWhoItIs) {
  EXPECT_FALSE(stage().identity().driver.empty());
  EXPECT_GT(stage().travel().value(), 0);
  EXPECT_GT(stage().resolution().value(), 0);
  EXPECT_LE(stage().resolution(), stage().travel());
}

TEST_P(StageContract, KnowsNothingBeforeItIsHomed) {
  EXPECT_EQ(stage().state(), StageState::kUnknown);
  const double before = backend_->truth_mm();
  EXPECT_EQ(kind_of([&] { stage().move_to(10.0_mm, soon()); }), Kind::kNotReady);
  EXPECT_EQ(kind_of([&] { stage().position(soon()); }), Kind::kNotReady);
  EXPECT_EQ(backend_->truth_mm(), before);
}

TEST_P(StageContract, StandsAtZeroWhenHomed) {
  EXPECT_EQ(stage().home(soon()).value(), 0);
  EXPECT_EQ(stage().state(), StageState::kIdle);
  EXPECT_EQ(stage().position(soon()).value(), 0);
  EXPECT_NEAR(backend_->truth_mm(), 0, 1e-9);
  EXPECT_EQ(stage().home(soon()).value(), 0) << "a second time";
}

TEST_P(StageContract, ReachesTheNearestStepAndSaysWhere) {
  home();
  for (const double mm : {50.0, 16.7, 0.0, 167.0, 100.0503, 83.5}) {
    const Length reached = stage().move_to(Length::of(mm), soon());
    EXPECT_NEAR(reached.value(), mm, tolerance_mm());
    EXPECT_NEAR(backend_->truth_mm(), reached.value(), backend_->settling_mm() + 1e-6);
    EXPECT_EQ(stage().position(soon()), reached);
    EXPECT_EQ(stage().state(), StageState::kIdle);
    EXPECT_FALSE(backend_->moves_now());
  }
}

TEST_P(StageContract, RefusesWhatIsBeyondItsTravel) {
  home();
  stage().move_to(20.0_mm, soon());
  const double before = backend_->truth_mm();
  for (const double mm :
       {-0.001, 167.001, -1e9, 1e9, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(kind_of([&] { stage().move_to(Length::of(mm), soon()); }), Kind::kOutOfRange) << mm;
    EXPECT_EQ(stage().state(), StageState::kIdle);
  }
  EXPECT_EQ(backend_->truth_mm(), before);
}

TEST_P(StageContract, GivesUpAtTheDeadline) {
  home();
  const Nanoseconds start = backend_->clock().now_ns();
  const Deadline deadline = backend_->clock().in(Duration::of(0.02));
  EXPECT_EQ(kind_of([&] { stage().move_to(167.0_mm, deadline); }), Kind::kTimeout);
  EXPECT_LE(backend_->clock().now_ns() - start, 520'000'000);
  EXPECT_THAT(stage().state(), ::testing::AnyOf(StageState::kUnknown, StageState::kIdle));
  // Nothing is left undone: homing makes it as new.
  EXPECT_EQ(stage().home(soon()).value(), 0);
  EXPECT_NEAR(stage().move_to(16.7_mm, soon()).value(), 16.7, tolerance_mm());
}

TEST_P(StageContract, TakesNoOrderThatWasCancelledBefore) {
  home();
  std::stop_source source;
  source.request_stop();
  const Deadline cancelled = backend_->clock().in(Duration::of(20), source.get_token());
  EXPECT_THROW(stage().move_to(167.0_mm, cancelled), Cancelled);
  EXPECT_NEAR(backend_->truth_mm(), 0, 1);
  EXPECT_FALSE(backend_->moves_now());
}

TEST_P(StageContract, CancelledInAMoveItStands) {
  home();
  std::stop_source source;
  const Deadline deadline = backend_->clock().in(Duration::of(20), source.get_token());
  if (!backend_->takes_real_time()) source.request_stop();
  const std::jthread canceller = when_it_moves([&] { source.request_stop(); });
  EXPECT_THROW(stage().move_to(167.0_mm, deadline), Cancelled);
  EXPECT_FALSE(backend_->moves_now());
  const double stands = backend_->truth_mm();
  if (stage().state() == StageState::kIdle) {
    EXPECT_NEAR(stage().position(soon()).value(), stands,
                backend_->settling_mm() + stage().resolution().value());
  }
  if (backend_->can_be_stopped()) {
    EXPECT_LT(stands, 166);
    EXPECT_EQ(stage().state(), StageState::kIdle) << "a stop in order keeps the position";
  }
}

TEST_P(StageContract, StopsFromAnotherThread) {
  home();
  if (!backend_->takes_real_time()) {
    stage().stop();
    EXPECT_EQ(stage().state(), StageState::kIdle) << "there was nothing to stop";
    return;
  }
  {
    const std::jthread stopper = when_it_moves([&] { stage().stop(); });
    EXPECT_EQ(kind_of([&] { stage().move_to(167.0_mm, soon()); }), Kind::kRefused);
  }
  EXPECT_FALSE(backend_->moves_now());
  if (backend_->can_be_stopped()) {
    EXPECT_LT(backend_->truth_mm(), 166);
  }
  EXPECT_NEAR(stage().move_to(16.7_mm, soon()).value(), 16.7, tolerance_mm()) << "goes on";
}

TEST_P(StageContract, ForeseesHowLongItTakes) {
  const Duration none = stage().move_duration(0.0_mm), some = stage().move_duration(10.0_mm),
                 all = stage().move_duration(stage().travel());
  EXPECT_GE(none.value(), 0);
  EXPECT_LT(none, some);
  EXPECT_LT(some, all);
  EXPECT_GE(stage().home_duration(), all - none);
  EXPECT_TRUE(std::isfinite(stage().home_duration().value()));
}

INSTANTIATE_TEST_SUITE_P(Stages, StageContract,
                         ::testing::Values(Maker{"simulated",
                                                 []() -> std::unique_ptr<StageBackend> {
                                                   return std::make_unique<TwinStageBackend>();
                                                 }},
                                           Maker{"grbl",
                                                 []() -> std::unique_ptr<StageBackend> {
                                                   return std::make_unique<GrblBackend>();
                                                 }},
                                           Maker{"arduino_gantry",
                                                 []() -> std::unique_ptr<StageBackend> {
                                                   return std::make_unique<ArduinoBackend>();
                                                 }}),
                         [](const ::testing::TestParamInfo<Maker>& maker) {
                           return maker.param.name;
                         });

}  // namespace
}  // namespace wheatstone
