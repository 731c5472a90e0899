#include "sim/wire/still/ptp_camera_firmware.h"

#include <gmock/gmock.h>

#include <opencv2/core.hpp>

#include "core/camera_raw.h"
#include "tests/sim/still/ptp_host.h"

namespace wheatstone {
namespace {

constexpr Nanoseconds kSecond = 1'000'000'000;
constexpr std::uint32_t k250th = 1U << 16 | 250;

class PtpCamera : public ::testing::Test {
 protected:
  void open() {
    EXPECT_EQ(host_.ask(ptp::kOpenSession, {1})->code, ptp::kOk);
    for (const std::uint32_t step : {1U, 2U, 3U})
      EXPECT_EQ(host_.ask(ptp::kConnect, {step})->code, ptp::kOk);
  }
  std::uint16_t code_of(std::uint16_t operation, std::vector<std::uint32_t> parameters = {}) {
    return host_.ask(operation, std::move(parameters))->code;
  }

  World world_{"card", 0.02, 7};
  PtpCameraFirmware camera_{world_};
  PtpHost host_{camera_};
};

TEST_F(PtpCamera, AnswersOutsideOfASessionOnlyWhoItIs) {
  EXPECT_EQ(code_of(ptp::kGetDeviceInfo), ptp::kOk);
  EXPECT_EQ(code_of(ptp::kGetStorageIds), ptp::kSessionNotOpen);
  open();
  EXPECT_EQ(code_of(ptp::kOpenSession, {2}), ptp::kSessionOpen);
  EXPECT_EQ(code_of(ptp::kGetStorageIds), ptp::kOk);
  EXPECT_EQ(code_of(ptp::kCloseSession), ptp::kOk);
  EXPECT_EQ(code_of(ptp::kGetStorageIds), ptp::kSessionNotOpen);
  EXPECT_EQ(code_of(ptp::kOpenSession, {0}), ptp::kBadParameter);
}

TEST_F(PtpCamera, RefusesWhatItDoesNotKnow) {
  open();
  EXPECT_EQ(code_of(0x1014), ptp::kUnsupported);
  EXPECT_EQ(code_of(ptp::kGetObject, {5}), ptp::kBadHandle);
  EXPECT_EQ(code_of(ptp::kGetObject, {ptp::kShot}), ptp::kBadHandle) << "nothing was taken";
  EXPECT_EQ(code_of(ptp::kConnect, {4}), ptp::kBadParameter);
  EXPECT_EQ(code_of(ptp::kGetStorageInfo, {9}), ptp::kBadStorage);
}

TEST_F(PtpCamera, SetsWhatItOffers) {
  open();
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, k250th), ptp::kOk);
  EXPECT_EQ(camera_.shutter_code(), k250th);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, 30U << 16 | 1), ptp::kOk);
  EXPECT_EQ(camera_.shutter_code(), 300U << 16 | 10) << "as the body writes it";
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, k250th), ptp::kOk);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, 1U << 16 | 251), ptp::kBadValue);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, 1U << 16), ptp::kBadValue);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kSettableShutter, 2, 1), ptp::kBadParameter);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kObjectsWaiting, 2, 1), ptp::kBadProperty);
  EXPECT_EQ(host_.set(ptp::kSetValue, 0xd999, 2, 1), ptp::kBadProperty);
  EXPECT_EQ(host_.set(ptp::kSetValue, ptp::kFullPress, 2, 2), ptp::kBadProperty) << "is a button";
  EXPECT_EQ(camera_.shutter_code(), k250th);
}

TEST_F(PtpCamera, TakesWhatTheTwinTakes) {
  open();
  world_.light.led_drive = 1;
  host_.set(ptp::kSetValue, ptp::kSettableShutter, 4, k250th);
  World twin_world("card", 0.02, 7);
  twin_world.light.led_drive = 1;
  SimulatedCamera twin(twin_world, true);
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(host_.press(), ptp::kOk);
    EXPECT_EQ(code_of(ptp::kGetObjectInfo, {ptp::kShot}), ptp::kBadHandle) << "still exposing";
    host_.now_ns += kSecond;
    EXPECT_EQ(code_of(ptp::kGetObjectInfo, {ptp::kShot}), ptp::kOk);
    const auto event = camera_.interrupt_in(host_.now_ns);
    EXPECT_EQ(camera_.properties().at(ptp::kObjectsWaiting).current, 0x8001U);
    const auto object = host_.ask(ptp::kGetObject, {ptp::kShot});
    ASSERT_EQ(object->code, ptp::kOk);
    const CameraRaw raw = decode_camera_raw(object->data, "shot");
    const RawFrame expected =
        twin.expose(Duration::of(1.0 / 250), twin_world.clock.in(Duration::of(1)));
    EXPECT_EQ(cv::norm(raw.mosaic.dn, expected.mosaic.dn, cv::NORM_INF), 0);
    EXPECT_EQ(raw.exposure_s, 1.0 / 250);
    EXPECT_EQ(raw.serial, expected.camera_serial);
    EXPECT_EQ(raw.white_dn, world_.camera_profile.white_dn);
    EXPECT_EQ(camera_.pictures_waiting(), 0U);
  }
}

TEST_F(PtpCamera, TellsOfAPictureOnce) {
  open();
  host_.press();
  EXPECT_FALSE(camera_.interrupt_in(host_.now_ns));
  host_.now_ns += kSecond;
  const auto event = camera_.interrupt_in(host_.now_ns);
  ASSERT_TRUE(event);
  EXPECT_EQ(number_at<std::uint16_t>(*event, 6), ptp::kObjectAdded);
  EXPECT_EQ(number_at<std::uint32_t>(*event, kPtpHeaderBytes), ptp::kShot);
  EXPECT_FALSE(camera_.interrupt_in(host_.now_ns));
}

TEST_F(PtpCamera, TakesNoneWhileItExposesOrIsFull) {
  open();
  EXPECT_EQ(host_.press(), ptp::kOk);
  EXPECT_EQ(host_.press(), ptp::kBusy);
  host_.now_ns += kSecond;
  camera_.full = true;
  EXPECT_EQ(host_.press(), ptp::kStoreFull);
  camera_.full = false;
  EXPECT_EQ(host_.press(), ptp::kOk);
  EXPECT_EQ(camera_.pictures_waiting(), 2U);
}

TEST_F(PtpCamera, EndsAContainerOfWholePacketsWithAnEmptyOne) {
  open();
  camera_.spoil = [](std::uint16_t, PtpReply& reply) {
    if (reply.data) reply.data->resize(PtpCameraFirmware::kPacketBytes - kPtpHeaderBytes);
  };
  camera_.receive(encode({PtpType::kCommand, ptp::kGetStorageIds, 9, {}, {}}), 0);
  EXPECT_EQ(camera_.bulk_in(512, 0)->size(), 512U);
  EXPECT_EQ(camera_.bulk_in(512, 0)->size(), 0U);
  EXPECT_EQ(camera_.bulk_in(512, 0)->size(), kPtpHeaderBytes);
  EXPECT_FALSE(camera_.bulk_in(512, 0));
}

TEST_F(PtpCamera, HaltsOnWhatIsNoPtp) {
  open();
  camera_.receive(std::vector<std::byte>(40, std::byte{0xff}), 0);
  EXPECT_TRUE(camera_.halted());
  EXPECT_FALSE(camera_.bulk_in(512, 0));
  camera_.reset();
  EXPECT_FALSE(camera_.halted());
  open();
}

}  // namespace
}  // namespace wheatstone
