// Every line of the tables of faults of still cameras, carried out; and what is no fault but looks
// like one.

#include "tests/contract/still/still_faults.h"

#include <gmock/gmock.h>

#include <cerrno>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <thread>

#include "core/error.h"
#include "sim/wire/still/little_endian.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/still/still_backends.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;
using End = UsbReply::End;
using ::testing::HasSubstr;

const Duration kExposure = Duration::of(kSeriesS[0]);

Deadline soon() {
  return SteadyClock().in(Duration::of(5));
}

/// Of all bodies here: what they see is of no interest, and one takes a while to make.
World& world() {
  static World one("card", 0.02, 7);
  return one;
}

class FaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up_still(); }
  StillResources resources_;
};

/// The answer to one operation has another code.
auto refusal(std::uint16_t operation, std::uint16_t code) {
  return [=](std::uint16_t asked, PtpReply& reply) {
    if (asked == operation) reply.code = code;
  };
}
/// Transfers on the bulk-in endpoint end so, from the `nth` on.
auto ending(End end, int nth = 0) {
  return [=](std::uint8_t endpoint) mutable -> std::optional<End> {
    if (endpoint == StillUsbFirmware::kBulkIn && nth-- <= 0) return end;
    return std::nullopt;
  };
}
auto file_bytes(std::size_t at, std::uint32_t value) {
  return [=](std::vector<std::byte>& file) {
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<std::byte>(value >> 8 * i);
  };
}
/// Where the value of this tag of the DNG's second directory lies.
std::size_t exif_value(const std::vector<std::byte>& file, std::uint16_t tag) {
  std::size_t at = 8 + 2;
  while (number_at<std::uint16_t>(file, at) != 34665) at += 12;
  at = number_at<std::uint32_t>(file, at + 8) + 2;
  while (number_at<std::uint16_t>(file, at) != tag) at += 12;
  const bool inside = number_at<std::uint16_t>(file, at + 2) == 3;
  return inside ? at + 8 : number_at<std::uint32_t>(file, at + 8);
}

void inject(GphotoBackend& b, const std::string& fault, const std::string& state) {
  PtpCameraFirmware& f = b.firmware();
  const auto choices = [&](std::uint16_t property, std::vector<std::uint32_t> only) {
    f.properties().at(property).current = only[0];
    f.properties().at(property).choices = std::move(only);
  };
  const auto garbage = [](std::vector<std::byte>& bytes) {
    std::fill(bytes.begin(), bytes.end(), std::byte{0x5a});
  };
  // From the moment the host does this.
  const auto once = [&](std::uint16_t operation, const std::function<void()>& act) {
    f.spoil = [=](std::uint16_t asked, PtpReply&) {
      if (asked == operation) act();
    };
  };
  const std::map<std::string, std::function<void()>> faults = {
      {"not plugged in", [&] {}},
      {"another serial", [&] {}},
      {"another model", [&] {}},
      {"two of them, none named", [&] {}},
      {"wrong USB mode", [&] {}},
      {"in use", [&] {}},
      {"not permitted", [&] {}},
      {"unplugged",
       [&] {
         if (state == "opening") b.usb().meet = ending(End::kUnplugged, 6);
         if (state == "triggering")
           once(ptp::kControl, [&] { b.usb().meet = ending(End::kUnplugged); });
         if (state == "fetching")
           once(ptp::kGetObject, [&] { b.usb().meet = ending(End::kUnplugged, 1); });
       }},
      {"silence",
       [&] {
         if (state == "triggering")
           once(ptp::kControl, [&] { f.silent = true; });
         else
           f.silent = true;
       }},
      {"garbage", [&] { f.spoil_bytes = garbage; }},
      {"half a description",
       [&] {
         f.spoil = [](std::uint16_t asked, PtpReply& reply) {
           if (asked == ptp::kGetDeviceInfo) reply.data->resize(7);
         };
       }},
      {"session refused", [&] { f.spoil = refusal(ptp::kOpenSession, ptp::kGeneralError); }},
      {"no exposure times",
       [&] {
         f.properties().erase(ptp::kShutter);
         f.properties().erase(ptp::kSettableShutter);
       }},
      {"no ISO 100",
       [&] {
         choices(ptp::kIso, {200, 400});
       }},
      {"no raw files",
       [&] {
         choices(ptp::kQuality, {2, 3});
       }},
      {"ISO stays another",
       [&] {
         f.properties().at(ptp::kIso).current = 400;
         once(ptp::kSetValue, [&] { f.properties().at(ptp::kIso).current = 400; });
       }},
      {"answer to another question",
       // One that has not been asked yet: answers to earlier ones are passed over, and waiting for
       // the right one times out.
       [&] { f.spoil_bytes = [](std::vector<std::byte>& bytes) { bytes[9] ^= std::byte{0x40}; }; }},
      {"half an answer", [&] { f.cut_after = 40; }},
      {"endpoint halted for good", [&] { b.usb().meet = ending(End::kStall); }},
      {"transmission errors", [&] { b.usb().meet = ending(End::kError); }},
      {"settings cannot be read",
       [&] { f.spoil = refusal(ptp::kAllProperties, ptp::kGeneralError); }},
      {"exposure refused", [&] { f.spoil = refusal(ptp::kSetValue, ptp::kBadValue); }},
      {"another exposure read back",
       [&] { f.round_shutter = [](std::uint32_t) { return 1U << 16 | 200; }; }},
      {"exposure cannot be set any more", [&] { f.properties().erase(ptp::kSettableShutter); }},
      {"card full", [&] { f.full = true; }},
      {"camera busy", [&] { f.spoil = refusal(ptp::kControl, ptp::kBusy); }},
      {"button refused", [&] { f.spoil = refusal(ptp::kControl, ptp::kGeneralError); }},
      {"no picture comes", [&] { f.takes_nothing = true; }},
      {"longer than the deadline", [&] {}},
      {"picture refused", [&] { f.spoil = refusal(ptp::kGetObject, ptp::kBadHandle); }},
      {"half a picture, then silence", [&] { once(ptp::kGetObject, [&] { f.cut_after = 9000; }); }},
      {"file cut short", [&] { f.spoil_file = [](auto& file) { file.resize(file.size() / 2); }; }},
      {"file of zeros",
       [&] {
         f.spoil_file = [](auto& file) { std::fill(file.begin(), file.end(), std::byte{}); };
       }},
      {"JPEG in place of raw",
       [&] {
         f.spoil_file = [](auto& file) {
           file = {std::byte{0xff}, std::byte{0xd8}, std::byte{0xff}, std::byte{0xe0}};
           file.resize(5000);
         };
       }},
      {"other exposure in the file",
       [&] {
         f.spoil_file = [](auto& file) { file_bytes(exif_value(file, 33434) + 4, 200)(file); };
       }},
      {"other ISO in the file",
       [&] { f.spoil_file = [](auto& file) { file_bytes(exif_value(file, 34855), 400)(file); }; }},
      {"power-cycle command fails", [&] {}},
      {"power-cycle command hangs", [&] {}},
  };
  b.peer().with_firmware(faults.at(fault));
}

void heal(GphotoBackend& b) {
  b.peer().with_firmware([&] {
    PtpCameraFirmware& f = b.firmware();
    f.silent = f.full = f.takes_nothing = false;
    f.round_shutter = nullptr;
    f.spoil = nullptr;
    f.spoil_bytes = f.spoil_file = nullptr;
    f.cut_after = SIZE_MAX;
    f.properties() = camera_properties(true);
    b.usb().meet = nullptr;
  });
}

/// Only a time-out may need the deadline.
Deadline limit(const FaultCase& fault, const Deadline& d) {
  return fault.error == Kind::kTimeout ? d : soon();
}

class GphotoFaults : public FaultTest {
 protected:
  void expect_not_opened(const FaultCase& fault, GphotoBackend& b) {
    const std::string what = fault.fault;
    GphotoCameraSettings settings = quick_settings();
    std::optional<GphotoBackend> second;
    if (what == "not plugged in") b.unplug();
    if (what == "another serial") settings.serial = "NOT-THIS-ONE";
    if (what == "another model") settings.model = "EOS 5D";
    if (what == "two of them, none named")
      second.emplace(world(), PtpCameraOptions{}, StillUsbFirmware::kPcRemote, "2");
    if (what == "in use") b.peer().refuse_claims(EBUSY);
    std::optional<AsNobody> nobody;
    if (what == "not permitted") {
      b.peer().forbid();
      nobody.emplace();
    }
    const std::string message =
        expect_fault(fault, [&](const Deadline& d) { GphotoCamera(settings, limit(fault, d)); });
    if (what == "not permitted") {
      EXPECT_THAT(message, HasSubstr("udev rules"));
    }
    // Lets go of the call that libgphoto2 would stay in for its own time-outs.
    if (what == "silence") b.unplug();
  }
};

TEST_P(GphotoFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state, after = fault.after;
  PtpCameraOptions options;
  GphotoBackend b(
      world(), options,
      what == "wrong USB mode" ? StillUsbFirmware::kFilesOnly : StillUsbFirmware::kPcRemote);
  if (what == "unplugged" || what == "in use" || (what == "silence" && state == "opening"))
    resources_.pardon_libgphoto2();
  if (state == "opening") {
    inject(b, what, state);
    expect_not_opened(fault, b);
    return;
  }
  GphotoCameraSettings settings = quick_settings();
  if (what == "power-cycle command fails") settings.power_cycle = "exit 3";
  if (what == "power-cycle command hangs") {
    settings.power_cycle = "sleep 60";
    settings.power_cycle_limit = Duration::of(0.2);
  }
  b.open(settings);
  b.camera().expose(Duration::of(kSeriesS[1]), soon());
  if (state == "after a time-out") {
    b.firmware().takes_nothing = true;
    EXPECT_EQ(kind_of([&] { b.camera().expose(kExposure, SteadyClock().in(Duration::of(0.1))); }),
              Kind::kTimeout);
  }
  inject(b, what, state);
  const bool long_one =
      what == "longer than the deadline" || (state == "exposing" && what == "unplugged");
  std::jthread hand;
  if (what == "unplugged" && (state == "idle" || state == "exposing")) {
    if (state == "idle") b.unplug();
    if (state == "exposing")
      hand = std::jthread([&] {
        SteadyClock().wait_until(SteadyClock().in(Duration::of(0.15)).at_ns);
        b.unplug();
      });
  }
  const std::string message = expect_fault(fault, [&](const Deadline& d) {
    b.camera().expose(long_one ? Duration::of(1) : kExposure, limit(fault, d));
  });
  if (what == "card full") {
    EXPECT_THAT(message, HasSubstr("empty"));
  }
  if (hand.joinable()) hand.join();
  if (after == "gone") {
    EXPECT_EQ(kind_of([&] { b.camera().expose(kExposure, soon()); }), Kind::kDisconnected);
    return;
  }
  // It works again when the fault is over.
  heal(b);
  const RawFrame frame = b.camera().expose(kExposure, soon());
  EXPECT_EQ(frame.exposure, kExposure);
}

INSTANTIATE_TEST_SUITE_P(Cameras, GphotoFaults, ::testing::ValuesIn(kGphotoFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class ReplayFaults : public FaultTest {};

TEST_P(ReplayFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  ReplayStillBackend b;
  if (what == "no folder") b.unplug();
  if (what == "empty folder") {
    b.unplug();
    std::filesystem::create_directory(b.folder());
  }
  if (what == "damaged file")
    write_text_atomically(b.folder() / "DSC00.dng", "no picture any more");
  if (std::string(fault.state) == "opening") {
    expect_fault(fault, [&](const Deadline&) { b.camera(); });
    return;
  }
  b.camera();
  if (what == "no more files")
    for (std::size_t i = 0; i < 2 * kSeriesS.size(); ++i)
      b.camera().expose(Duration::of(kSeriesS[i % kSeriesS.size()]), soon());
  if (what == "folder taken away") b.unplug();
  const bool other = what == "another exposure than recorded";
  const auto ask = [&](const Deadline& d) {
    b.camera().expose(Duration::of(kSeriesS[other ? 1 : 0]), d);
  };
  expect_fault(fault, ask);
  if (std::string(fault.after) == "stays") {
    EXPECT_EQ(kind_of([&] { ask(soon()); }), fault.error);
  } else {
    EXPECT_EQ(b.camera().expose(kExposure, soon()).exposure, kExposure);
  }
}

INSTANTIATE_TEST_SUITE_P(Cameras, ReplayFaults, ::testing::ValuesIn(kReplayFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedStillFaults : public FaultTest {};

TEST_P(SimulatedStillFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  TwinStillBackend b;
  const auto take = [&] { return b.camera().expose(kExposure, b.clock().in(Duration::of(1))); };
  arm(b.world().faults, "camera", fault);
  expect_fault(fault, [&](const Deadline&) { take(); });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { take(); }), Kind::kDisconnected);
    b.world().faults.reconnect("camera");
  }
  EXPECT_EQ(take().exposure, kExposure);
}

INSTANTIATE_TEST_SUITE_P(Cameras, SimulatedStillFaults, ::testing::ValuesIn(kSimulatedStillFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class GphotoOddities : public FaultTest {};

TEST_F(GphotoOddities, ALatePictureIsNotTakenForTheNextOne) {
  GphotoBackend b(world());
  b.open(quick_settings());
  EXPECT_EQ(
      kind_of([&] { b.camera().expose(Duration::of(0.5), SteadyClock().in(Duration::of(0.2))); }),
      Kind::kTimeout);
  const RawFrame frame = b.camera().expose(kExposure, soon());
  EXPECT_EQ(frame.exposure, kExposure);
  EXPECT_EQ(b.firmware().pictures_waiting(), 0U);
}

TEST_F(GphotoOddities, PicturesThatNobodyAskedForAreDropped) {
  GphotoBackend b(world());
  b.camera();
  for (int i = 0; i < 2; ++i)
    b.peer().with_firmware([&] { b.firmware().take_picture(SteadyClock().now_ns()); });
  SteadyClock().wait_until(SteadyClock().in(Duration::of(0.1)).at_ns);
  EXPECT_EQ(b.camera().expose(kExposure, soon()).exposure, kExposure);
  EXPECT_EQ(b.firmware().pictures_waiting(), 0U);
}

TEST_F(GphotoOddities, AbortLetsGoOfAnExposureAtOnce) {
  GphotoBackend b(world());
  b.camera();
  for (const bool by_token : {false, true}) {
    std::stop_source stop;
    const std::jthread hand([&] {
      SteadyClock().wait_until(SteadyClock().in(Duration::of(0.2)).at_ns);
      if (by_token)
        stop.request_stop();
      else
        b.camera().abort();
    });
    const SteadyClock clock;
    const Nanoseconds start = clock.now_ns();
    EXPECT_THROW(b.camera().expose(Duration::of(1), clock.in(Duration::of(9), stop.get_token())),
                 Cancelled);
    EXPECT_LE(clock.now_ns() - start, 350'000'000);
    EXPECT_EQ(b.camera().expose(kExposure, soon()).exposure, kExposure);
  }
}

TEST_F(GphotoOddities, ASingleStallIsCleared) {
  GphotoBackend b(world());
  b.camera();
  b.peer().with_firmware([&] {
    b.usb().meet = [first = true](std::uint8_t endpoint) mutable -> std::optional<End> {
      if (endpoint != StillUsbFirmware::kBulkIn || !std::exchange(first, false))
        return std::nullopt;
      return End::kStall;
    };
  });
  EXPECT_EQ(b.camera().expose(kExposure, soon()).exposure, kExposure);
}

TEST_F(GphotoOddities, ThePowerCycleCommandBringsItBack) {
  const TemporaryFolder folder;
  GphotoCameraSettings settings = quick_settings();
  settings.power_cycle = "echo done >> " + (folder.path / "cycled").string();
  GphotoBackend b(world());
  b.open(settings);
  b.peer().with_firmware([&] { b.firmware().takes_nothing = true; });
  EXPECT_EQ(kind_of([&] { b.camera().expose(kExposure, SteadyClock().in(Duration::of(0.2))); }),
            Kind::kTimeout);
  EXPECT_FALSE(std::filesystem::exists(folder.path / "cycled"));
  heal(b);
  for (int i = 0; i < 2; ++i) b.camera().expose(kExposure, soon());
  EXPECT_EQ(read_text(folder.path / "cycled"), "done\n") << "once";
}

TEST_F(GphotoOddities, ASessionLeftOpenByACrashIsTakenOver) {
  GphotoBackend b(world());
  const std::vector<std::byte> open = encode({PtpType::kCommand, ptp::kOpenSession, 0, {77}, {}});
  b.peer().with_firmware([&] {
    b.firmware().receive(open, 0);
    b.firmware().bulk_in(512, 0);
  });
  EXPECT_TRUE(b.firmware().session_open());
  EXPECT_EQ(b.camera().expose(kExposure, soon()).exposure, kExposure);
}

TEST_F(GphotoOddities, BackInAnotherSocketItIsFoundByItsSerial) {
  resources_.pardon_libgphoto2();
  GphotoCameraSettings settings = quick_settings();
  PtpCameraOptions one, other;
  one.serial = "ONE";
  other.serial = "OTHER";
  GphotoBackend first(world(), one);
  settings.serial = "ONE";
  first.open(settings);
  const std::string before = first.camera().identity().address;
  first.unplug();
  EXPECT_EQ(kind_of([&] { first.camera().expose(kExposure, soon()); }), Kind::kDisconnected);
  PtpCameraFirmware a(world(), other), b(world(), one);
  StillUsbFirmware usb_a(a), usb_b(b);
  const UsbDevicePeer peer_a(still_bed(), usb_a, "3"), peer_b(still_bed(), usb_b, "4");
  GphotoCamera camera(settings, soon());
  EXPECT_EQ(camera.identity().serial, "ONE");
  EXPECT_NE(camera.identity().address, before);
  EXPECT_EQ(camera.expose(kExposure, soon()).camera_serial, "ONE");
}

TEST_F(GphotoOddities, ListsWhatIsPluggedInAndWhyItCannotBeUsed) {
  resources_.pardon_libgphoto2();
  PtpCameraFirmware a(world()), b(world()), c(world());
  StillUsbFirmware usb_a(a), usb_b(b, StillUsbFirmware::kFilesOnly), usb_c(c);
  const UsbDevicePeer peer_a(still_bed(), usb_a, "1"), peer_b(still_bed(), usb_b, "2");
  UsbDevicePeer peer_c(still_bed(), usb_c, "3");
  peer_c.refuse_claims(EBUSY);
  std::vector<StillCameraFound> found = list_still_cameras();
  std::sort(found.begin(), found.end(),
            [](const auto& x, const auto& y) { return x.address < y.address; });
  ASSERT_EQ(found.size(), 3U);
  EXPECT_THAT(found[0].model, HasSubstr("A7r III"));
  EXPECT_EQ(found[0].serial, world().camera_profile.serial);
  EXPECT_EQ(found[0].trouble, "");
  EXPECT_THAT(found[1].trouble, HasSubstr("PC Remote"));
  EXPECT_THAT(found[2].trouble, HasSubstr("claim"));
}

TEST_F(GphotoOddities, NamesThatATerminalWouldObeyAreMadeHarmless) {
  PtpCameraOptions options;
  options.model = "ILCE\x1b[2J\n7";
  options.version = std::string(254, '9');
  GphotoBackend b(world(), options);
  EXPECT_EQ(b.camera().identity().model, "ILCE?[2J?7");
  EXPECT_EQ(b.camera().identity().firmware.size(), 254U);
}

}  // namespace
}  // namespace wheatstone
