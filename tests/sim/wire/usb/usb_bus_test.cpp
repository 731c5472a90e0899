// The emulated USB bus as plain libusb sees it.

#include "sim/wire/usb/usb_bus.h"

#include <gmock/gmock.h>
#include <libusb.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <thread>

#include "tests/sim/wire/usb/echo_firmware.h"

namespace wheatstone {
namespace {

using Bytes = std::vector<std::uint8_t>;
using ::testing::ElementsAre;

MockBed& bed() {
  static MockBed one;
  return one;
}

class UsbBus : public ::testing::Test {
 protected:
  UsbBus() { EXPECT_EQ(libusb_init(&context_), 0); }
  ~UsbBus() override {
    close();
    libusb_exit(context_);
  }
  void open() {
    handle_ = libusb_open_device_with_vid_pid(context_, 0x1209, 0x0001);
    ASSERT_NE(handle_, nullptr);
    ASSERT_EQ(libusb_claim_interface(handle_, 0), 0);
  }
  void close() {
    if (handle_) libusb_close(handle_);
    handle_ = nullptr;
  }
  int write(Bytes bytes, unsigned timeout_ms = 1000) {
    int n = 0;
    const int r = libusb_bulk_transfer(handle_, 0x01, bytes.data(), static_cast<int>(bytes.size()),
                                       &n, timeout_ms);
    return r ? r : n;
  }
  Bytes read(unsigned timeout_ms = 1000) {
    Bytes bytes(4096);
    int n = 0;
    result_ = libusb_bulk_transfer(handle_, 0x82, bytes.data(), static_cast<int>(bytes.size()), &n,
                                   timeout_ms);
    bytes.resize(static_cast<std::size_t>(n));
    return bytes;
  }
  int listed() {
    libusb_device** list = nullptr;
    const auto n = libusb_get_device_list(context_, &list);
    libusb_free_device_list(list, 1);
    return static_cast<int>(n);
  }

  Echo echo_;
  UsbDevicePeer peer_{bed(), echo_};
  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  int result_ = 0;
};

TEST_F(UsbBus, ListsTheDeviceWithItsDescriptors) {
  libusb_device** list = nullptr;
  ASSERT_EQ(libusb_get_device_list(context_, &list), 1);
  libusb_device_descriptor d{};
  EXPECT_EQ(libusb_get_device_descriptor(list[0], &d), 0);
  EXPECT_EQ(d.idVendor, 0x1209);
  EXPECT_EQ(d.bcdDevice, 0x0123);
  EXPECT_EQ(libusb_get_device_speed(list[0]), LIBUSB_SPEED_FULL);
  libusb_config_descriptor* c = nullptr;
  ASSERT_EQ(libusb_get_active_config_descriptor(list[0], &c), 0);
  EXPECT_EQ(c->interface[0].altsetting[0].bNumEndpoints, 3);
  libusb_free_config_descriptor(c);
  libusb_free_device_list(list, 1);
  open();
  std::array<unsigned char, 64> text{};
  EXPECT_EQ(libusb_get_string_descriptor_ascii(handle_, d.iSerialNumber, text.data(), 64), 2);
  EXPECT_STREQ(reinterpret_cast<char*>(text.data()), "E7");
}

TEST_F(UsbBus, AnotherProgramSeesTheSameDevice) {
  const std::string client = WHEATSTONE_LSUSB;
  if (client.empty()) GTEST_SKIP() << "lsusb is not installed (package usbutils)";
  const std::string command = "timeout 20 " + client + " -v -d 1209:0001 2>/dev/null";
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), n);
  EXPECT_EQ(::pclose(pipe.release()), 0);
  for (const char* expected :
       {"bcdDevice            1.23", "3 E7", "2 Echo", "EP 2 IN", "Interrupt"})
    EXPECT_THAT(text, ::testing::HasSubstr(expected));
}

TEST_F(UsbBus, CarriesControlTransfers) {
  open();
  Bytes out = {1, 2, 3}, in(8);
  EXPECT_EQ(libusb_control_transfer(handle_, 0x40, 7, 0, 0, out.data(), 3, 1000), 3);
  EXPECT_EQ(libusb_control_transfer(handle_, 0xc0, 7, 0, 0, in.data(), 8, 1000), 3);
  EXPECT_THAT(Bytes(in.begin(), in.begin() + 3), ElementsAre(1, 2, 3));
  EXPECT_EQ(libusb_control_transfer(handle_, 0xc0, 8, 0, 0, in.data(), 8, 1000), LIBUSB_ERROR_PIPE);
}

TEST_F(UsbBus, CarriesBulkTransfers) {
  open();
  for (const std::size_t n : {1U, 64U, 1600U}) {
    const Bytes bytes(n, static_cast<std::uint8_t>(n));
    EXPECT_EQ(write(bytes), static_cast<int>(n));
    EXPECT_EQ(read(), bytes);
  }
}

TEST_F(UsbBus, WaitsWithoutWorking) {
  open();
  timespec before{}, after{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
  EXPECT_TRUE(read(300).empty());
  EXPECT_EQ(result_, LIBUSB_ERROR_TIMEOUT);
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
  EXPECT_LT((after.tv_sec - before.tv_sec) * 1000 + (after.tv_nsec - before.tv_nsec) / 1000000, 60);
}

TEST_F(UsbBus, InterruptsWhenItIsTime) {
  open();
  peer_.with_firmware([&] { echo_.event_ns = SteadyClock().in(Duration::of(0.05)).at_ns; });
  std::array<unsigned char, 8> bytes{};
  int n = 0;
  EXPECT_EQ(libusb_interrupt_transfer(handle_, 0x83, bytes.data(), 8, &n, 1000), 0);
  EXPECT_EQ(n, 2);
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 2), ElementsAre(1, 2));
}

TEST_F(UsbBus, HaltsUntilCleared) {
  open();
  peer_.with_firmware([&] { echo_.stall = true; });
  EXPECT_EQ(write({1}), LIBUSB_ERROR_PIPE);
  EXPECT_EQ(write({1}), LIBUSB_ERROR_PIPE);
  EXPECT_EQ(libusb_clear_halt(handle_, 0x01), 0);
  EXPECT_EQ(write({1}), 1);
}

TEST_F(UsbBus, GivesAnInterfaceToOneOnly) {
  open();
  libusb_device_handle* second = libusb_open_device_with_vid_pid(context_, 0x1209, 0x0001);
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(libusb_claim_interface(second, 0), LIBUSB_ERROR_BUSY);
  EXPECT_EQ(libusb_release_interface(handle_, 0), 0);
  EXPECT_EQ(libusb_claim_interface(second, 0), 0);
  libusb_close(second);
}

TEST_F(UsbBus, IsGoneWhenUnplugged) {
  open();
  std::jthread hand([&] {
    SteadyClock().wait_until(SteadyClock().in(Duration::of(0.05)).at_ns);
    peer_.unplug();
  });
  read(2000);
  EXPECT_EQ(result_, LIBUSB_ERROR_NO_DEVICE);
  hand.join();
  EXPECT_EQ(write({1}), LIBUSB_ERROR_NO_DEVICE);
  for (int i = 0; i < 100 && listed(); ++i)
    SteadyClock().wait_until(SteadyClock().in(Duration::of(0.01)).at_ns);
  EXPECT_EQ(listed(), 0);
}

TEST_F(UsbBus, GoesInTheMiddleOfATransfer) {
  open();
  peer_.with_firmware([&] { echo_.gone = true; });
  EXPECT_EQ(write({1}), LIBUSB_ERROR_NO_DEVICE);
}

TEST_F(UsbBus, AnnouncesArrivalAndLeaving) {
  int arrived = 0, left = 0;
  struct Counts {
    int *arrived, *left;
  } counts{&arrived, &left};
  libusb_hotplug_callback_handle callback = 0;
  ASSERT_EQ(libusb_hotplug_register_callback(
                context_, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0,
                0x1209, 0x0001, LIBUSB_HOTPLUG_MATCH_ANY,
                [](libusb_context*, libusb_device*, libusb_hotplug_event event, void* user) {
                  const auto& c = *static_cast<Counts*>(user);
                  ++*(event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED ? c.arrived : c.left);
                  return 0;
                },
                &counts, &callback),
            0);
  const auto wait_for = [&](const int& count) {
    for (int i = 0; i < 100 && !count; ++i) {
      timeval slice{0, 20000};
      libusb_handle_events_timeout(context_, &slice);
    }
    return count;
  };
  Echo other;
  auto second = std::make_unique<UsbDevicePeer>(bed(), other, "2");
  EXPECT_EQ(wait_for(arrived), 1);
  second->unplug();
  EXPECT_EQ(wait_for(left), 1);
}

}  // namespace
}  // namespace wheatstone
