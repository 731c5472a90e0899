// Every line of the tables of faults of blink(1) and of the simulated markers, carried out.

#include <gmock/gmock.h>

#include <optional>
#include <string>

#include "tests/contract/lights/lights_fault_run.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

class Blink1Faults : public LightsFaultTest {};

TEST_P(Blink1Faults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  Blink1Backend backend(hid_bed(), 0, what == "another name" ? "2A00BEEF" : "2A00CAFE");
  std::optional<Blink1Backend> twin;
  if (what == "two with one name") twin.emplace(hid_bed(), 1);
  if (std::string(fault.state) == "opening") {
    expect_not_opened(fault, backend);
    return;
  }
  Blink1Firmware& firmware = backend.firmware();
  if (what == "one LED broken")
    backend.peer().with_firmware([&] { firmware.first_led_broken = true; });
  carry_out(fault, backend);
  backend.peer().with_firmware([&] { firmware.first_led_broken = false; });
  if (fault.error != Kind::kDisconnected) expect_works_again(backend);
}

INSTANTIATE_TEST_SUITE_P(Lights, Blink1Faults, ::testing::ValuesIn(kBlink1Faults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedMarkersFaults : public LightsFaultTest {};

TEST_P(SimulatedMarkersFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const bool setting = std::string(fault.state) == "setting";
  TwinLightsBackend backend;
  MarkerLights& lights = backend.lights();
  const auto in_time = [&] { return backend.clock().in(Duration::of(1)); };
  if (!setting) lights.set(1, in_time());
  arm(backend.world().faults, "markers", fault);
  expect_fault(fault, [&](const Deadline&) {
    setting ? lights.set(1, in_time()) : static_cast<void>(lights.state(in_time()));
  });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { lights.state(in_time()); }), Kind::kDisconnected);
    return;
  }
  EXPECT_EQ(lights.state(in_time()), setting ? 0U : 1U);
  lights.set(lights.all(), in_time());
  EXPECT_EQ(backend.truth(), lights.all());
}

INSTANTIATE_TEST_SUITE_P(Lights, SimulatedMarkersFaults,
                         ::testing::ValuesIn(kSimulatedMarkersFaults),
                         [](const auto& fault) { return test_name(fault.param); });

}  // namespace
}  // namespace wheatstone
