// Every line of the table of faults of relay boards, carried out.

#include <gmock/gmock.h>

#include <optional>
#include <string>

#include "tests/contract/lights/lights_fault_run.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

class HidRelayFaults : public LightsFaultTest {};

TEST_P(HidRelayFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  RelayBackend backend(hid_bed(), 0, what == "another name" ? "OTHER" : "BITFT",
                       what == "another product" ? 9 : 4);
  std::optional<RelayBackend> twin;
  if (what == "two with one name") twin.emplace(hid_bed(), 1);
  RelayFirmware& firmware = backend.firmware();
  if (what == "stuck relay" && state == "opening")
    backend.peer().with_firmware([&] {
      firmware.set_report(0, std::string("\xff\x02\0\0\0\0\0\0", 8), 0);
      firmware.stuck = 2;
    });
  if (state == "opening") {
    expect_not_opened(fault, backend);
    return;
  }
  backend.lights();
  if (what == "stuck relay") backend.peer().with_firmware([&] { firmware.stuck = 1; });
  carry_out(fault, backend);
  backend.peer().with_firmware([&] { firmware.stuck = 0; });
  if (fault.error != Kind::kDisconnected) expect_works_again(backend);
}

INSTANTIATE_TEST_SUITE_P(Lights, HidRelayFaults, ::testing::ValuesIn(kHidRelayFaults),
                         [](const auto& fault) { return test_name(fault.param); });

}  // namespace
}  // namespace wheatstone
