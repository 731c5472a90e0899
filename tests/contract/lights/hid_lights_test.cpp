// What is no fault of marker lights but looks like one, and other programs at the emulated devices.

#include <gmock/gmock.h>

#include <cerrno>
#include <memory>
#include <string>

#include "hardware/hid/hid_drivers.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/lights/lights_backends.h"
#include "tests/program_output.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

Deadline soon() {
  return SteadyClock().in(Duration::of(5));
}

class HidLightsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { warm_up_hid(); }
  MockResources resources_{0.5};
};

TEST_F(HidLightsTest, ABoardThatWasLeftLitIsDarkOnceItIsOpen) {
  RelayBackend backend(hid_bed());
  backend.peer().with_firmware(
      [&] { backend.firmware().set_report(0, std::string("\xfe\0\0\0\0\0\0\0", 8), 0); });
  EXPECT_EQ(backend.truth(), 15U);
  backend.lights();
  EXPECT_EQ(backend.truth(), 0U);
}

TEST_F(HidLightsTest, OneOrTwoFailedTransfersPassUnnoticed) {
  RelayBackend relay(hid_bed(), 0);
  Blink1Backend blink1(hid_bed(), 1);
  for (HidLightsBackend* backend :
       {static_cast<HidLightsBackend*>(&relay), static_cast<HidLightsBackend*>(&blink1)}) {
    MarkerLights& lights = backend->lights();
    int failures = 2;
    backend->peer().with_firmware([&] {
      backend->firmware().spoil = [&](bool, std::string&) { return failures-- > 0 ? EPROTO : 0; };
    });
    lights.set(1, soon());
    EXPECT_EQ(backend->truth(), 1U);
    EXPECT_LT(failures, 0);
    failures = 2;
    EXPECT_EQ(lights.state(soon()), 1U);
    backend->peer().with_firmware([&] { backend->firmware().spoil = nullptr; });
  }
}

TEST_F(HidLightsTest, BackUnderAnotherPathTheyAreFoundByTheirIdentity) {
  RelayBackend relay(hid_bed(), 0);
  EXPECT_EQ(relay.lights().identity().address, "/dev/hidraw0");
  Blink1Backend blink1(hid_bed(), 1);
  EXPECT_EQ(blink1.lights().identity().address, "/dev/hidraw1");
  relay.unplug();
  blink1.unplug();
  EXPECT_TRUE(list_hid_lights().empty());
  const RelayBackend elsewhere(hid_bed(), 4);
  const Blink1Backend elsewhere_too(hid_bed(), 3);
  EXPECT_EQ(kind_of([&] { relay.lights().state(soon()); }), Kind::kDisconnected) << "it stays gone";
  EXPECT_EQ(RelayBoard(RelayBackend::settings(), soon()).identity().address, "/dev/hidraw4");
  EXPECT_EQ(Blink1(Blink1Backend::settings(), soon()).identity().address, "/dev/hidraw3");
}

TEST_F(HidLightsTest, TwoBoardsAreToldApartByTheirNames) {
  RelayBackend first(hid_bed(), 0, "AAAAA"), second(hid_bed(), 1, "BBBBB", 8);
  RelayBoard board({"BBBBB", Duration::of(0), nullptr}, soon());
  EXPECT_EQ(board.count(), 8);
  EXPECT_EQ(board.identity().model, "USBRelay8");
  board.set(0x81, soon());
  EXPECT_EQ(first.truth(), 0U);
  EXPECT_EQ(second.truth(), 0x81U);
}

TEST_F(HidLightsTest, AnOrderThatIsCarriedOutLateDoesNotStayLit) {
  RelayBackend backend(hid_bed());
  MarkerLights& lights = backend.lights();
  backend.peer().delay(Duration::of(0.3));
  EXPECT_EQ(kind_of([&] { lights.set(lights.all(), SteadyClock().in(Duration::of(0.1))); }),
            Kind::kTimeout);
  backend.peer().delay({});
  const SteadyClock clock;
  const Nanoseconds end = soon().at_ns;
  while (backend.truth() == 0 && clock.now_ns() < end)
    SteadyClock().wait_until(clock.now_ns() + 100'000);
  EXPECT_EQ(lights.state(soon()), 0U);
  EXPECT_EQ(backend.truth(), 0U);
}

TEST_F(HidLightsTest, GoneWithAnObjectThatIsNotToldToGoDark) {
  RelayBackend backend(hid_bed());
  backend.lights().set(3, soon());
  backend.close();
  EXPECT_EQ(backend.truth(), 0U);
}

TEST_F(HidLightsTest, ListSaysWhatIsPluggedInAndWhatToDo) {
  const RelayBackend first(hid_bed(), 0), second(hid_bed(), 1);
  const RelayBackend third(hid_bed(), 2, "THIRD");
  Blink1Backend blink1(hid_bed(), 3);
  RelayBackend silent(hid_bed(), 4);
  silent.peer().with_firmware(
      [&] { silent.firmware().spoil = [](bool, std::string&) { return EPIPE; }; });
  const RelayBoard taken({"THIRD", Duration::of(0), nullptr}, soon());
  const auto line = [](const char* address, const char* node, const auto& problem) {
    return ::testing::AllOf(Field(&HidLightFound::address, address),
                            Field(&HidLightFound::node, node),
                            Field(&HidLightFound::problem, problem));
  };
  EXPECT_THAT(list_hid_lights(),
              ElementsAre(line("relay BITFT", "/dev/hidraw0", HasSubstr("; unplug one")),
                          line("relay BITFT", "/dev/hidraw1", HasSubstr("; unplug one")),
                          line("relay THIRD", "/dev/hidraw2", HasSubstr("in use")),
                          line("", "/dev/hidraw4", HasSubstr("refuses")),
                          line("blink1 2A00CAFE", "/dev/hidraw3", ::testing::IsEmpty())));
}

TEST_F(HidLightsTest, WhatTheDevicesSayIsFitForATerminal) {
  RelayBackend board(hid_bed(), 0, "\x1b[2J\x07");
  const auto found = list_relay_boards();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].board, "");
  ASSERT_TRUE(found[0].trouble);
  EXPECT_EQ(found[0].trouble->kind(), Kind::kProtocol);
  EXPECT_EQ(std::string(found[0].trouble->what()).find('\x1b'), std::string::npos);
}

TEST_F(HidLightsTest, ReportsAreInTheTranscript) {
  const TemporaryFolder folder;
  RelayBackend backend(hid_bed());
  {
    RelayBoardSettings settings = RelayBackend::settings();
    settings.transcript = std::make_shared<Transcript>(folder.path / "lights.jsonl");
    RelayBoard board(settings, soon());
    board.set(2, soon());
  }
  std::string sent;
  for (const TranscriptEntry& e : read_transcript(folder.path / "lights.jsonl"))
    sent += (e.to_device ? "> " : "< ") + hex_of(e.bytes) + "\n";
  const std::string off = "> 00 fc 00 00 00 00 00 00 00\n", dark = "< 42 49 54 46 54 00 00 00\n";
  EXPECT_EQ(sent,
            off + dark + dark + "> 00 ff 02 00 00 00 00 00 00\n< 42 49 54 46 54 00 00 02\n" + off);
}

TEST_F(HidLightsTest, AnotherProgramSwitchesTheSameRelays) {
  const std::string client = WHEATSTONE_USBRELAY;
  if (client.empty()) GTEST_SKIP() << "usbrelay is not installed (package usbrelay)";
  RelayBackend backend(hid_bed());
  const std::string usbrelay = "timeout 20 " + client + " ";
  EXPECT_THAT(output_of(usbrelay), HasSubstr("BITFT_1=0\nBITFT_2=0\nBITFT_3=0\nBITFT_4=0\n"));
  output_of(usbrelay + "BITFT_2=1 BITFT_4=1");
  EXPECT_EQ(backend.truth(), 10U);
  EXPECT_THAT(output_of(usbrelay), HasSubstr("BITFT_1=0\nBITFT_2=1\nBITFT_3=0\nBITFT_4=1\n"));
  output_of(usbrelay + "BITFT_2=0");
  EXPECT_EQ(backend.truth(), 8U);
  output_of(usbrelay + "BITFT_0=NEW01");
  EXPECT_EQ(RelayBoard({"NEW01", Duration::of(0), nullptr}, soon()).count(), 4)
      << "as the driver advises for two of one name";
}

}  // namespace
}  // namespace wheatstone
