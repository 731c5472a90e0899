#pragma once
// How a fault of marker lights on a HID device is carried out.

#include <gmock/gmock.h>
#include <unistd.h>

#include <cerrno>
#include <map>
#include <string>
#include <thread>

#include "tests/contract/fault_call.h"
#include "tests/contract/lights/lights_backends.h"
#include "tests/contract/lights/lights_faults.h"

namespace wheatstone {

// Later than the deadlines of the calls.
inline constexpr Duration kLate = Duration::of(kFaultDeadlineS + 0.15);

inline Deadline soon() {
  return SteadyClock().in(Duration::of(5));
}

/// umockdev forgets the socket that it makes for an open() that fails. It is the lowest free
/// handle.
class ForgottenSocket {
 public:
  ForgottenSocket() { ::close(handle_); }
  ~ForgottenSocket() { ::close(handle_); }
  ForgottenSocket(const ForgottenSocket&) = delete;
  ForgottenSocket& operator=(const ForgottenSocket&) = delete;

 private:
  int handle_ = ::dup(STDIN_FILENO);
};

/// What goes over the bus, spoilt. Bytes of relay boards without a number, of blink(1) with it.
inline std::function<int(bool, std::string&)> spoiler(const std::string& fault) {
  const auto answer = [](const std::function<void(std::string&)>& change) {
    return [change](bool to_host, std::string& bytes) {
      if (to_host) change(bytes);
      return 0;
    };
  };
  const auto always = [](int error) { return [error](bool, std::string&) { return error; }; };
  const std::map<std::string, std::function<int(bool, std::string&)>> faults = {
      {"garbage", answer([](auto& b) { b.assign(b.size(), '\xff'); })},
      {"half a report", answer([](auto& b) { b.resize(b.size() / 2); })},
      {"stalls", always(EPIPE)},
      {"transfer error", always(EPROTO)},
      {"another state", answer([](auto& b) { b[7] ^= 2; })},
      {"channels that it lacks", answer([](auto& b) { b[7] |= '\x40'; })},
      {"answers as another", answer([](auto& b) { b[0] = 'X'; })},
      {"no version", answer([](auto& b) { b[3] = 'x'; })},
      {"answer to an earlier question", answer([](auto& b) { b[1] = 'v'; })},
      {"another colour", answer([](auto& b) { b[3] ^= 0x55; })},
      {"order lost", [](bool to_host, std::string& bytes) {
         const bool order = bytes[0] == '\xff' || bytes[1] == 'n';
         if (!to_host && order) bytes[0] = bytes[1] = 0;
         return 0;
       }}};
  const auto it = faults.find(fault);
  return it == faults.end() ? nullptr : it->second;
}

inline void inject(HidLightsBackend& backend, const std::string& fault, const std::string& state) {
  HidPeer& peer = backend.peer();
  if (fault == "silence")
    peer.silence(kLate);
  else if (fault == "late")
    peer.delay(kLate);
  else if (fault == "unplugged" || fault == "not there")
    peer.unplug();
  else if (fault == "unplugged in a transfer")
    peer.unplug_after(state == "setting" ? 2 : 1);
  else if (fault == "not permitted")
    peer.forbid();
  else
    peer.with_firmware([&] { backend.firmware().spoil = spoiler(fault); });
}

inline void heal(HidLightsBackend& backend) {
  backend.peer().silence({});
  backend.peer().delay({});
  backend.peer().with_firmware([&] { backend.firmware().spoil = nullptr; });
}

inline void expect_not_opened(const FaultCase& fault, HidLightsBackend& backend) {
  const std::string what = fault.fault, state = fault.state;
  std::unique_ptr<MarkerLights> holder;
  std::optional<ForgottenSocket> forgotten;
  std::optional<AsNobody> nobody;
  if (what == "in use") holder = backend.open(soon());
  inject(backend, what, state);
  if (what == "not permitted") {
    forgotten.emplace();
    nobody.emplace();
  }
  const std::string message = expect_fault(fault, [&](const Deadline& d) { backend.open(d); });
  if (what == "not permitted") {
    EXPECT_THAT(message, ::testing::HasSubstr("udev rules"));
  }
  if (what == "two with one name") {
    EXPECT_THAT(message, ::testing::HasSubstr("/dev/hidraw0"));
    EXPECT_THAT(message, ::testing::HasSubstr("/dev/hidraw1"));
    EXPECT_THAT(message, ::testing::HasSubstr("unplug one"));
  }
  EXPECT_EQ(backend.truth() & ~std::uint32_t{2}, 0U) << "but for the relay that is stuck";
}

inline void carry_out(const FaultCase& fault, HidLightsBackend& backend) {
  const std::string what = fault.fault, state = fault.state, after = fault.after;
  MarkerLights& lights = backend.lights();
  if (state == "reading") lights.set(1, soon());
  inject(backend, what, state);
  std::jthread hand;
  if (what == "switched off meanwhile")
    hand = std::jthread([&](const std::stop_token& stop) {
      while (!stop.stop_requested() && backend.truth() == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      lights.all_off();
    });
  expect_fault(fault, [&](const Deadline& d) {
    state == "setting" ? lights.set(1, d) : static_cast<void>(lights.state(d));
  });
  if (hand.joinable()) hand.join();
  if (after == "gone") {
    EXPECT_EQ(backend.truth(), 0U);
    EXPECT_EQ(kind_of([&] { lights.state(soon()); }), DeviceError::Kind::kDisconnected);
    EXPECT_EQ(kind_of([&] { lights.set(0, soon()); }), DeviceError::Kind::kDisconnected);
    return;
  }
  heal(backend);
  EXPECT_EQ(lights.state(soon()), after == "lit" ? 1U : 0U);
  EXPECT_EQ(backend.truth(), after == "lit" ? 1U : 0U);
}

inline void expect_works_again(HidLightsBackend& backend) {
  MarkerLights& lights = backend.lights();
  lights.set(lights.all(), soon());
  EXPECT_EQ(backend.truth(), lights.all());
}

class LightsFaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up_hid(); }
  MockResources resources_{0.5};
};

}  // namespace wheatstone
