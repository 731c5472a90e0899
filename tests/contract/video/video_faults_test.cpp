// Every line of the table of faults of video cameras, carried out; and what is no fault but looks
// like one.

#include "tests/contract/video/video_faults.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <map>
#include <opencv2/core.hpp>
#include <thread>

#include "core/random.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/video/video_backends.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

const VideoMode kMode{"Y12 ", 320, 240, 100}, kJpegMode{"MJPG", 320, 240, 100};

VideoSettings configure(VideoCamera& camera, const Deadline& d, const VideoMode& mode = kMode) {
  return camera.configure(mode, Duration::of(0.004), 1, d);
}

Deadline soon() {
  return SteadyClock().in(Duration::of(5));
}

/// An errno in place of the answer to one request.
void refuse(VideoFirmware& firmware, unsigned long request, int error) {
  firmware.spoil = [=](unsigned long asked, void*, int result) {
    return asked == request ? error : result;
  };
}

/// Changes the structure that answers one request.
template <class T>
void change(VideoFirmware& firmware, unsigned long request, const std::function<void(T&)>& act) {
  firmware.spoil = [=](unsigned long asked, void* argument, int result) {
    if (asked == request) act(*static_cast<T*>(argument));
    return result;
  };
}

void inject(V4l2Backend& backend, const std::string& fault, const std::string& state) {
  VideoFirmware& f = backend.firmware();
  const auto format = [&](const std::function<void(v4l2_pix_format&)>& act) {
    change<v4l2_format>(f, VIDIOC_S_FMT, [act](v4l2_format& v) { act(v.fmt.pix); });
  };
  const auto buffer = [&](const std::function<void(v4l2_buffer&)>& act) {
    change<v4l2_buffer>(f, VIDIOC_DQBUF, act);
  };
  const auto picture = [&](const std::function<void(std::vector<std::uint8_t>&)>& act) {
    f.spoil_picture = act;
  };
  const std::map<std::string, std::function<void()>> faults = {
      {"captures nothing",
       [&] {
         change<v4l2_capability>(f, VIDIOC_QUERYCAP, [](v4l2_capability& c) {
           c.device_caps = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
         });
       }},
      {"no camera", [&] { refuse(f, VIDIOC_QUERYCAP, ENOTTY); }},
      {"not permitted", [&] { refuse(f, VIDIOC_QUERYCAP, EACCES); }},
      {"no streaming",
       [&] {
         change<v4l2_capability>(f, VIDIOC_QUERYCAP, [](v4l2_capability& c) {
           c.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
         });
       }},
      {"lists without end", [&] { refuse(f, VIDIOC_ENUM_FMT, 0); }},
      {"in use", [&] { refuse(f, state == "starting" ? VIDIOC_REQBUFS : VIDIOC_S_FMT, EBUSY); }},
      {"another format",
       [&] { format([](v4l2_pix_format& p) { p.pixelformat = V4L2_PIX_FMT_H264; }); }},
      {"no size", [&] { format([](v4l2_pix_format& p) { p.width = 0; }); }},
      {"huge size", [&] { format([](v4l2_pix_format& p) { p.sizeimage = 0xffffffff; }); }},
      {"short lines", [&] { format([](v4l2_pix_format& p) { p.bytesperline = 639; }); }},
      {"small buffers", [&] { format([](v4l2_pix_format& p) { p.sizeimage /= 2; }); }},
      {"automatic exposure stays",
       [&] {
         change<v4l2_control>(f, VIDIOC_G_CTRL, [](v4l2_control& c) {
           if (c.id == V4L2_CID_EXPOSURE_AUTO) c.value = V4L2_EXPOSURE_APERTURE_PRIORITY;
         });
       }},
      {"value out of range", [&] { refuse(f, VIDIOC_S_CTRL, ERANGE); }},
      {"input or output error",
       [&] { refuse(f, state == "running" ? VIDIOC_DQBUF : VIDIOC_S_CTRL, EIO); }},
      {"no memory", [&] { refuse(f, VIDIOC_REQBUFS, ENOMEM); }},
      {"no buffers",
       [&] {
         change<v4l2_requestbuffers>(f, VIDIOC_REQBUFS,
                                     [](v4l2_requestbuffers& r) { r.count = 0; });
       }},
      {"wrong offsets",
       [&] { change<v4l2_buffer>(f, VIDIOC_QUERYBUF, [](v4l2_buffer& b) { b.m.offset += 1; }); }},
      {"bus full", [&] { refuse(f, VIDIOC_STREAMON, ENOSPC); }},
      {"silence", [&] { f.silent = true; }},
      {"ready and then not", [&] { refuse(f, VIDIOC_DQBUF, EAGAIN); }},
      {"every frame damaged",
       [&] { buffer([](v4l2_buffer& b) { b.flags |= V4L2_BUF_FLAG_ERROR; }); }},
      {"empty frames", [&] { buffer([](v4l2_buffer& b) { b.bytesused = 0; }); }},
      {"unknown buffer", [&] { buffer([](v4l2_buffer& b) { b.index = 99; }); }},
      {"half frames", [&] { picture([](auto& bytes) { bytes.resize(bytes.size() / 2); }); }},
      {"garbage for a picture",
       [&] { picture([](auto& bytes) { std::fill(bytes.begin(), bytes.end(), 0x5a); }); }},
      {"picture of another size", [&] {
         picture([](auto& bytes) {  // its header says 65535 lines
           for (std::size_t i = 0; i + 7 < bytes.size(); ++i)
             if (bytes[i] == 0xff && bytes[i + 1] == 0xc0) bytes[i + 5] = bytes[i + 6] = 0xff;
         });
       }}};
  if (fault == "unplugged")
    backend.unplug();
  else if (fault != "unplugged while waiting")
    backend.peer().with_firmware(faults.at(fault));
}

void expect_after(const std::string& after, VideoCamera& camera) {
  if (after == "gone") {
    EXPECT_EQ(kind_of([&] { camera.modes(soon()); }), Kind::kDisconnected);
    EXPECT_EQ(kind_of([&] { camera.next(soon()); }), Kind::kDisconnected);
  } else if (after == "stopped") {
    EXPECT_EQ(kind_of([&] { camera.next(soon()); }), Kind::kNotReady);
  }
}

class FaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up_video(); }
  VideoResources resources_;
};

class V4l2Faults : public FaultTest {};

void expect_not_opened(const FaultCase& fault, V4l2Backend& backend) {
  const std::string what = fault.fault;
  V4l2CameraSettings settings;
  settings.node = backend.peer().by_id();
  VideoFirmware second(backend.world());
  std::unique_ptr<V4l2Peer> other;
  std::unique_ptr<V4l2Camera> holder;
  if (what == "not there") {
    settings.node = "/wheatstone/no-such-node";
  } else if (what == "unknown serial") {
    settings.usb_serial = "none";
  } else if (what == "two with one serial") {
    other = std::make_unique<V4l2Peer>(video_bed(), second, V4l2PeerOptions{"video1"});
    settings.usb_serial = "SIM-VIDEO";
  } else if (what == "in use") {
    holder = std::make_unique<V4l2Camera>(settings);
  } else {
    inject(backend, what, fault.state);
  }
  expect_fault(fault, [&](const Deadline&) { V4l2Camera{settings}; });
}

TEST_P(V4l2Faults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  V4l2Backend backend(video_bed());
  if (state == "opening") {
    expect_not_opened(fault, backend);
    return;
  }
  VideoCamera& camera = backend.camera();
  const bool jpeg = what == "garbage for a picture" || what == "picture of another size";
  if (state == "starting" || state == "running")
    configure(camera, soon(), jpeg ? kJpegMode : kMode);
  if (state == "running") {
    camera.start(soon());
    camera.next(soon());
  }
  inject(backend, what, state);
  std::jthread hand;
  if (what == "unplugged while waiting") {
    backend.peer().with_firmware([&] { backend.firmware().silent = true; });
    hand = std::jthread([&] {
      SteadyClock().wait_until(SteadyClock().in(Duration::of(0.1)).at_ns);
      backend.unplug();
    });
  }
  expect_fault(fault, [&](const Deadline& d) {
    if (state == "listing")
      camera.modes(d);
    else if (state == "configuring")
      configure(camera, d);
    else if (state == "starting")
      camera.start(d);
    else
      for (;;) camera.next(d);  // pictures that were whole come first
  });
  if (hand.joinable()) hand.join();
  expect_after(fault.after, camera);
  if (fault.error == Kind::kDisconnected) return;
  if (what.find("frame") != std::string::npos || jpeg) {
    EXPECT_GT(camera.dropped(), 0U);
  }
  // It works again when the fault is over.
  backend.peer().with_firmware([&] {
    backend.firmware().spoil = {};
    backend.firmware().spoil_picture = {};
    backend.firmware().silent = false;
  });
  camera.stop();
  configure(camera, soon());
  camera.start(soon());
  EXPECT_EQ(camera.next(soon()).pixels.size(), cv::Size(320, 240));
}

INSTANTIATE_TEST_SUITE_P(Cameras, V4l2Faults, ::testing::ValuesIn(kV4l2Faults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedVideoFaults : public FaultTest {};

TEST_P(SimulatedVideoFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string state = fault.state;
  TwinVideoBackend backend;
  VideoCamera& camera = backend.camera();
  const auto in_time = [&] { return backend.clock().in(Duration::of(1)); };
  if (state == "starting" || state == "running") configure(camera, in_time());
  if (state == "running") camera.start(in_time());
  arm(backend.world().faults, "video", fault);
  expect_fault(fault, [&](const Deadline&) {
    if (state == "listing")
      camera.modes(in_time());
    else if (state == "configuring")
      configure(camera, in_time());
    else if (state == "starting")
      camera.start(in_time());
    else
      camera.next(in_time());
  });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { camera.next(in_time()); }), Kind::kDisconnected);
    backend.world().faults.reconnect("video");
  } else if (std::string(fault.after) == "stopped") {
    EXPECT_EQ(kind_of([&] { camera.next(in_time()); }), Kind::kNotReady);
  } else {
    camera.next(in_time());
  }
  camera.modes(in_time());
}

INSTANTIATE_TEST_SUITE_P(Cameras, SimulatedVideoFaults, ::testing::ValuesIn(kSimulatedVideoFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class V4l2Oddities : public FaultTest {};

TEST_F(V4l2Oddities, BackUnderAnotherPathItIsFoundByItsSerial) {
  V4l2Backend before(video_bed());
  EXPECT_EQ(before.camera().identity().address, "/dev/video0");
  before.unplug();
  EXPECT_THAT(list_video_cameras(), ::testing::IsEmpty());
  World world("card", 0.02, 7);
  VideoFirmware firmware(world);
  const V4l2Peer after(video_bed(), firmware, {"video3"});
  V4l2CameraSettings settings;
  settings.usb_serial = "SIM-VIDEO";
  V4l2Camera camera(settings);
  EXPECT_EQ(camera.identity().address, "/dev/video3");
  EXPECT_EQ(camera.identity().serial, "SIM-VIDEO");
}

TEST_F(V4l2Oddities, ListsWhatIsPluggedInAndWhyItCannotBeOpened) {
  World world("card", 0.02, 7);
  VideoFirmwareOptions other;
  other.card = "Gr\xc3\xbcn\x1b[2J";
  VideoFirmware a(world), b(world, other), c(world);
  c.spoil = [](unsigned long, void*, int) { return EACCES; };
  const V4l2Peer first(video_bed(), a, {"video0", "A"});
  const V4l2Peer second(video_bed(), b, {"video1", "B", other.card});
  const V4l2Peer third(video_bed(), c, {"video2", "C"});
  V4l2CameraSettings settings;
  settings.node = "/dev/video1";
  const V4l2Camera camera(settings);
  EXPECT_EQ(camera.identity().model, "Gr??n?[2J") << "nothing that a terminal would obey";
  const std::vector<VideoCameraFound> found = list_video_cameras();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].usb_serial, "A");
  EXPECT_EQ(found[0].trouble, "");
  EXPECT_EQ(found[1].node, "/dev/video1");
  EXPECT_THAT(found[1].trouble, ::testing::HasSubstr("in use"));
  EXPECT_THAT(found[2].trouble, ::testing::HasSubstr("ermission"));
}

TEST_F(V4l2Oddities, SequenceNumbersMayWrap) {
  VideoFirmwareOptions options;
  options.first_sequence = 0xfffffffd;
  V4l2Backend backend(video_bed(), V4l2Transfer::kMmap, options);
  configure(backend.camera(), soon());
  backend.camera().start(soon());
  std::uint32_t last = backend.camera().next(soon()).sequence;
  std::uint64_t missing = 0;
  for (int i = 0; i < 10; ++i) {
    const std::uint32_t now = backend.camera().next(soon()).sequence;
    missing += now - last - 1;
    last = now;
  }
  EXPECT_LT(last, 1000U);
  EXPECT_EQ(backend.camera().dropped(), missing);
}

TEST_F(V4l2Oddities, StampsThatCannotBeAreNotBelieved) {
  V4l2Backend backend(video_bed());
  configure(backend.camera(), soon());
  backend.camera().start(soon());
  EXPECT_TRUE(backend.camera().next(soon()).time_is_the_cameras);
  for (const long step_s : {-100L, 1000L}) {
    backend.peer().with_firmware([&] {
      change<v4l2_buffer>(backend.firmware(), VIDIOC_DQBUF,
                          [=](v4l2_buffer& b) { b.timestamp.tv_sec += step_s; });
    });
    const VideoFrame frame = backend.camera().next(soon());
    EXPECT_FALSE(frame.time_is_the_cameras);
    EXPECT_NEAR(static_cast<double>(SteadyClock().now_ns() - frame.mid_exposure_ns) * 1e-9, 0.002,
                0.1);
  }
}

TEST_F(V4l2Oddities, StampsAreMovedToMidExposure) {
  for (const bool of_start : {true, false}) {
    VideoFirmwareOptions options;
    options.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC |
                          static_cast<std::uint32_t>(of_start ? V4L2_BUF_FLAG_TSTAMP_SRC_SOE
                                                              : V4L2_BUF_FLAG_TSTAMP_SRC_EOF);
    V4l2Backend backend(video_bed(), V4l2Transfer::kMmap, options);
    configure(backend.camera(), soon());
    backend.camera().start(soon());
    Nanoseconds stamp = 0;
    backend.peer().with_firmware([&] {
      change<v4l2_buffer>(backend.firmware(), VIDIOC_DQBUF, [&](v4l2_buffer& b) {
        stamp = b.timestamp.tv_sec * 1'000'000'000 + b.timestamp.tv_usec * 1000;
      });
    });
    const VideoFrame frame = backend.camera().next(soon());
    EXPECT_EQ(frame.mid_exposure_ns - stamp, of_start ? 2'000'000 : -2'000'000);
  }
}

TEST_F(V4l2Oddities, EveryFormatShowsTheSamePicture) {
  VideoFirmwareOptions options;
  options.noise = false;
  V4l2Backend backend(video_bed(), V4l2Transfer::kMmap, options);
  backend.world().light.led_drive = 1;
  VideoCamera& camera = backend.camera();
  const auto frame = [&](const char* format) {
    configure(camera, soon(), {format, 320, 240, 100});
    camera.start(soon());
    const cv::Mat pixels = camera.next(soon()).pixels;
    camera.stop();
    return pixels;
  };
  cv::Mat codes;
  frame("Y12 ").convertTo(codes, CV_64F);
  // Of 12-bit codes: how much one step is worth, and what coding may lose.
  const std::map<std::string, std::pair<double, double>> formats = {
      {"Y16 ", {1.0 / 16, 0}}, {"Y10 ", {4, 3}}, {"Y10P", {4, 3}}, {"GREY", {16, 15}},
      {"RGGB", {16, 15}},      {"RG10", {4, 3}}, {"pRAA", {4, 3}}, {"YUYV", {4095.0 / 255, 40}},
      {"MJPG", {16, 400}}};
  for (const auto& [format, scale] : formats) {
    cv::Mat pixels = frame(format.c_str());
    if (pixels.channels() == 3) cv::extractChannel(pixels, pixels, 1);
    pixels.convertTo(pixels, CV_64F, scale.first);
    EXPECT_LE(cv::norm(pixels, codes, cv::NORM_INF), scale.second) << format;
  }
}

TEST_F(V4l2Oddities, WhatItSeesIsWhatTheTwinSees) {
  V4l2Backend wire(video_bed());
  TwinVideoBackend twin;
  std::map<std::uint32_t, cv::Mat> seen;
  int compared = 0;
  for (VideoBackend* b : {static_cast<VideoBackend*>(&twin), static_cast<VideoBackend*>(&wire)}) {
    b->world().light.led_drive = 0.5;
    const auto in_time = [&] { return b->clock().in(Duration::of(5)); };
    configure(b->camera(), in_time());
    b->camera().start(in_time());
    for (int i = 0; i < 5; ++i) {
      const VideoFrame frame = b->camera().next(in_time());
      if (b == &twin) seen[frame.sequence] = frame.pixels;
      if (seen.contains(frame.sequence)) {
        EXPECT_EQ(cv::norm(frame.pixels, seen[frame.sequence], cv::NORM_INF), 0);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 5);
}

// No fault case: it is busy asking all the time.
TEST(V4l2Garbled, AnswersAreRefusedOrTaken) {
  VideoFirmwareOptions options;
  options.noise = false;
  V4l2Backend backend(video_bed(), V4l2Transfer::kMmap, options);
  VideoCamera& camera = backend.camera();
  RandomStream random(7, 0);
  // A byte or two of one answer in thirty; not where the kernel says what it has mapped.
  backend.peer().with_firmware([&] {
    backend.firmware().spoil = [&](unsigned long request, void* argument, int result) {
      if (request == VIDIOC_QUERYBUF || request == VIDIOC_REQBUFS || random.next() % 30)
        return result;
      for (int i = 0; i < 2; ++i)
        static_cast<std::uint8_t*>(argument)[random.next() % _IOC_SIZE(request)] =
            static_cast<std::uint8_t>(random.next());
      return result;
    };
  });
  int refused = 0, taken = 0;
  for (int i = 0; i < 60; ++i) {
    const auto d = [] { return SteadyClock().in(Duration::of(0.5)); };
    const auto end = kind_of([&] {
      configure(camera, d());
      camera.start(d());
      camera.next(d());
      ++taken;
    });
    camera.stop();
    refused += end.has_value();
    EXPECT_NE(end, Kind::kDisconnected);
  }
  EXPECT_GT(refused, 5);
  EXPECT_GT(taken, 5);
}

}  // namespace
}  // namespace wheatstone
