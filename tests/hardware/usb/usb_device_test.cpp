// The libusb transport on an emulated bus.

#include "hardware/usb/usb_device.h"

#include <gmock/gmock.h>

#include <thread>

#include "sim/wire/usb/usb_bus.h"
#include "tests/contract/fault_call.h"
#include "tests/sim/wire/usb/echo_firmware.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;
using Bytes = std::vector<std::uint8_t>;

MockBed& bed() {
  static MockBed one;
  return one;
}

Deadline in(double seconds) {
  return SteadyClock().in(Duration::of(seconds));
}

class UsbDeviceTest : public ::testing::Test {
 protected:
  Bytes read(double seconds = 1) { return device_.read(0x82, 4096, in(seconds)); }

  Echo echo_;
  UsbDevicePeer peer_{bed(), echo_};
  UsbDevice device_{"the echo", {0x1209, 0x0001, "E7"}, 0};
};

TEST_F(UsbDeviceTest, KnowsWhatItOpened) {
  EXPECT_EQ(device_.about().manufacturer, "Wheatstone");
  EXPECT_EQ(device_.about().model, "Echo");
  EXPECT_EQ(device_.about().version, 0x0123);
  EXPECT_THAT(device_.about().address, ::testing::StartsWith("usb 1:"));
}

TEST_F(UsbDeviceTest, CarriesBytesBothWays) {
  for (const std::size_t n : {1U, 64U, 1600U}) {
    const Bytes bytes(n, static_cast<std::uint8_t>(n));
    device_.write(0x01, bytes, in(1));
    EXPECT_EQ(read(), bytes);
  }
}

TEST_F(UsbDeviceTest, AsksAndIsToldWhatIsNotKnown) {
  peer_.with_firmware([&] { echo_.held = {3, 2, 1}; });
  EXPECT_EQ(device_.ask({0xc0, 7, 0, 0}, 8, in(1)), (Bytes{3, 2, 1}));
  EXPECT_EQ(device_.ask({0xc0, 7, 0, 0}, 2, in(1)), (Bytes{3, 2}));
  EXPECT_EQ(device_.ask({0xc0, 8, 0, 0}, 8, in(1)), std::nullopt);
}

TEST_F(UsbDeviceTest, RecoversFromAStallOnce) {
  peer_.with_firmware([&] { echo_.stall = true; });  // until it is cleared
  device_.write(0x01, Bytes{5}, in(1));
  EXPECT_EQ(read(), Bytes{5});
}

TEST_F(UsbDeviceTest, KeepsDeadlinesAndCanBeUsedAfterwards) {
  const Nanoseconds start = SteadyClock().now_ns();
  EXPECT_EQ(kind_of([&] { read(0.2); }), Kind::kTimeout);
  EXPECT_NEAR(static_cast<double>(SteadyClock().now_ns() - start) * 1e-9, 0.3, 0.15);
  EXPECT_EQ(kind_of([&] { read(0); }), Kind::kTimeout);
  device_.write(0x01, Bytes{5}, in(1));
  EXPECT_EQ(read(), Bytes{5}) << "and nothing is lost";
}

TEST_F(UsbDeviceTest, CanBeStoppedByRequestAndByAnotherThread) {
  std::stop_source source;
  const auto later = [](const std::function<void()>& act) {
    return std::jthread([act] {
      SteadyClock().wait_until(in(0.05).at_ns);
      act();
    });
  };
  {
    const std::jthread hand = later([&] { source.request_stop(); });
    Deadline d = in(2);
    d.cancel = source.get_token();
    EXPECT_THROW(device_.read(0x82, 64, d), Cancelled);
  }
  const std::jthread hand = later([&] { device_.abort(); });
  EXPECT_EQ(kind_of([&] { read(2); }), Kind::kRefused);
}

TEST_F(UsbDeviceTest, NoticesThatItLeftWhileNobodyAsked) {
  peer_.unplug();
  EXPECT_EQ(kind_of([&] { read(); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { device_.write(0x01, Bytes{1}, in(1)); }), Kind::kDisconnected);
  EXPECT_EQ(kind_of([&] { device_.ask({0xc0, 7, 0, 0}, 8, in(1)); }), Kind::kDisconnected);
  device_.write_at_once(0x01, Bytes{1});
  // Another one in its place is another device.
  Echo other;
  const UsbDevicePeer again(bed(), other);
  EXPECT_EQ(kind_of([&] { read(); }), Kind::kDisconnected);
  UsbDevice reopened("the echo", {0x1209, 0x0001, "E7"}, 0);
  reopened.write(0x01, Bytes{1}, in(1));
  EXPECT_EQ(reopened.read(0x82, 64, in(1)), Bytes{1});
}

TEST_F(UsbDeviceTest, IsListedWithItsTrouble) {
  const auto found = list_usb_devices(0x1209, 0x0001);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].serial, "E7");
  EXPECT_THAT(found[0].trouble, ::testing::HasSubstr("end the other program"));
  EXPECT_THAT(list_usb_devices(0x1209, 0x0002), ::testing::IsEmpty());
}

}  // namespace
}  // namespace wheatstone
