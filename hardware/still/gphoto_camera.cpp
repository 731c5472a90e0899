#include "hardware/still/gphoto_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "core/camera_raw.h"
#include "hardware/still/exposure_text.h"
#include "hardware/still/file_type.h"
#include "hardware/still/gphoto_body.h"
#include "hardware/transport/child_process.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr double kSixthStop = 1.0 / 6;
constexpr Nanoseconds kMs = 1'000'000;
constexpr Duration kSlice = Duration::of(0.02);   // of waiting for a picture
constexpr Duration kDrain = Duration::of(0.002);  // for what has come already
constexpr Duration kFarewell = Duration::of(0.4);
constexpr double kIso = 100;

double stops_apart(double a, double b) {
  return std::abs(std::log2(a / b));
}

std::string what(const GphotoCameraSettings& s) {
  return s.serial.empty() ? "still camera" : "still camera " + s.serial;
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void nap() {
  SteadyClock clock;
  clock.wait_until(clock.now_ns() + 10 * kMs);
}

/// Sets it unless it is so already, and sees that it stays so.
void establish(GphotoBody& body, const std::string& setting, const std::string& value,
               Duration settle) {
  std::vector<std::string> choices;
  if (body.has(setting)) choices = body.choices(setting);
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    throw DeviceError(Kind::kRefused, fmt::format("the camera offers no {} {} now", setting, value),
                      "set it to manual exposure and raw files");
  const SteadyClock clock;
  const Deadline end = clock.in(settle);
  std::string is = body.value(setting);
  if (is != value) body.set(setting, value);
  do is = body.value(setting);
  while (is != value && clock.now_ns() < end.at_ns);
  if (is != value)
    throw DeviceError(Kind::kFault,
                      fmt::format("the camera has {} {} after being set to {}", setting, is, value),
                      "set it to manual exposure and raw files");
}

}  // namespace

/// Lives on the thread; whoever waits looks at it only when the call is over.
struct GphotoCamera::Connection {
  std::unique_ptr<GphotoBody> body;
  DeviceIdentity identity;
  std::vector<Exposure> exposures;
  Nanoseconds late_until_ns = 0;  // a picture that nobody waited for may come till then

  struct Shot {
    std::vector<std::byte> file;
    std::string name;
    Nanoseconds triggered_ns = 0;
  };
  std::shared_ptr<Shot> shot;

  void open(const GphotoCameraSettings&);
  void prepare(Duration settle);
  void take(const Exposure&, const GphotoCameraSettings&, const std::stop_token&);
  void drop_late_pictures(const std::stop_token&);
};

void GphotoCamera::Connection::open(const GphotoCameraSettings& settings) {
  body.reset();
  std::vector<std::string> others;
  std::vector<GphotoPort> fitting;
  bool wrong_mode = false;
  for (const GphotoPort& port : gphoto_ports()) {
    others.push_back(port.model);
    if (lower_case(port.model).find(lower_case(settings.model)) == std::string::npos) continue;
    if (port.can_capture)
      fitting.push_back(port);
    else
      wrong_mode = true;
  }
  if (fitting.empty() && wrong_mode)
    throw DeviceError(Kind::kRefused, "the camera's USB mode is wrong: it hands over files only",
                      "set its USB connection to PC Remote");
  if (settings.serial.empty() && fitting.size() > 1)
    throw DeviceError(Kind::kNotFound,
                      fmt::format("{} still cameras are plugged in", fitting.size()),
                      "name one by its serial");
  for (const GphotoPort& port : fitting) {
    auto candidate = std::make_unique<GphotoBody>(port, settings.usb_patience);
    const std::string serial = candidate->value("serialnumber");
    if (!settings.serial.empty() && serial != settings.serial) continue;
    body = std::move(candidate);
    identity = {"gphoto2", body->value("cameramodel"), serial, body->value("deviceversion"),
                port.address};
    prepare(settings.settle);
    return;
  }
  throw DeviceError(Kind::kNotFound, fmt::format("the {} is not plugged in", what(settings)),
                    others.empty() ? "plug it in and switch it on" : "found only " + others[0]);
}

void GphotoCamera::Connection::prepare(Duration settle) {
  establish(*body, "iso", "100", settle);
  establish(*body, "imagequality", "RAW", settle);
  exposures.clear();
  std::vector<std::string> texts;
  if (body->has("shutterspeed")) texts = body->choices("shutterspeed");
  for (const std::string& text : texts)
    if (const auto seconds = exposure_seconds(text)) exposures.push_back({text, *seconds});
  if (exposures.empty())
    throw DeviceError(Kind::kRefused, "the camera offers no exposure times",
                      "turn its dial to manual exposure");
  std::sort(exposures.begin(), exposures.end(),
            [](const Exposure& a, const Exposure& b) { return a.seconds < b.seconds; });
}

void GphotoCamera::Connection::drop_late_pictures(const std::stop_token& stop) {
  const SteadyClock clock;
  do {
    while (const auto late = body->next_picture(kDrain)) {
      body->fetch(*late);
      body->remove(*late);
      late_until_ns = 0;
    }
  } while (clock.now_ns() < late_until_ns && !stop.stop_requested());
  late_until_ns = 0;
}

void GphotoCamera::Connection::take(const Exposure& exposure, const GphotoCameraSettings& settings,
                                    const std::stop_token& stop) {
  shot = std::make_shared<Shot>();
  const SteadyClock clock;
  drop_late_pictures(stop);
  establish(*body, "shutterspeed", exposure.text, settings.settle);
  if (stop.stop_requested()) return;
  shot->triggered_ns = clock.now_ns();
  late_until_ns = clock.in(Duration::of(2 * exposure.seconds) + 2 * settings.delivery).at_ns;
  try {
    body->trigger();
  } catch (const DeviceError& e) {
    if (e.kind() == Kind::kRefused) late_until_ns = 0;
    throw;
  }
  // Asking a body while it exposes is of no use, and not all of them like it.
  const Nanoseconds end_ns = shot->triggered_ns + static_cast<Nanoseconds>(1e9 * exposure.seconds);
  while (clock.now_ns() < end_ns && !stop.stop_requested()) {
    body->require_plugged_in();
    nap();
  }
  std::optional<CameraFilePath> picture;
  while (!stop.stop_requested() && !(picture = body->next_picture(kSlice))) nap();
  if (!picture) return;
  late_until_ns = 0;
  shot->file = body->fetch(*picture);
  shot->name = picture->name;
  body->remove(*picture);
}

GphotoCamera::GphotoCamera(const GphotoCameraSettings& settings, const Deadline& deadline)
    : settings_(settings), thread_(what(settings)), connection_(std::make_shared<Connection>()) {
  connect(deadline);
}

GphotoCamera::~GphotoCamera() {
  thread_.finish([c = std::move(connection_)](const std::stop_token&) { c->body.reset(); },
                 kFarewell);
}

void GphotoCamera::connect(const Deadline& deadline) {
  thread_.run(
      [c = connection_, s = settings_](const std::stop_token&) {
        try {
          c->open(s);
        } catch (...) {
          c->body.reset();
          throw;
        }
      },
      deadline);
  identity_ = connection_->identity;
  exposures_ = connection_->exposures;
}

void GphotoCamera::cycle_power(const Deadline& deadline) {
  const SteadyClock clock;
  const Nanoseconds end_ns = std::min(deadline.at_ns, clock.in(settings_.power_cycle_limit).at_ns);
  thread_.run([c = connection_](const std::stop_token&) { c->body.reset(); }, deadline);
  const std::string command = "the command that switches the " + what(settings_) + " off and on";
  const ChildResult result =
      run_child(command, {"/bin/sh", "-c", settings_.power_cycle}, {end_ns, deadline.cancel});
  if (result.exit_status != 0)
    throw DeviceError(Kind::kFault,
                      fmt::format("{} failed with status {}", command, result.exit_status),
                      "switch it by hand; correct the command (" + settings_.power_cycle + ")");
}

const GphotoCamera::Exposure& GphotoCamera::nearest(Duration wanted) const {
  const double seconds = wanted.value();
  const auto apart = [&](const Exposure& e) { return stops_apart(e.seconds, seconds); };
  const auto best =
      std::min_element(exposures_.begin(), exposures_.end(),
                       [&](const auto& a, const auto& b) { return apart(a) < apart(b); });
  if (!(seconds > 0 && apart(*best) <= kSixthStop))
    throw DeviceError(Kind::kOutOfRange, fmt::format("the camera cannot expose for {} s", seconds),
                      fmt::format("use one of its times, from {} to {} s", exposures_.front().text,
                                  exposures_.back().text));
  return *best;
}

Duration GphotoCamera::offered_exposure(Duration wanted) const {
  return Duration::of(nearest(wanted).seconds);
}

Duration GphotoCamera::frame_duration(Duration exposure) const {
  return exposure + settings_.delivery;
}

std::uintmax_t GphotoCamera::largest_file(std::uintmax_t photosites) const {
  // 16 bits for each; the masked margin and previews are a quarter of that at most.
  constexpr std::uintmax_t kHeaders = 1 << 20;
  return 5 * photosites / 2 + kHeaders;
}

RawFrame GphotoCamera::expose(Duration wanted, Deadline deadline) {
  const Exposure exposure = nearest(wanted);
  if (lost_)
    throw DeviceError(Kind::kDisconnected, "the " + what(settings_) + " was lost before",
                      "plug it in again, then run the command again");
  std::shared_ptr<Connection::Shot> shot;
  if (std::exchange(timed_out_, false) && !settings_.power_cycle.empty()) cycle_power(deadline);
  try {
    thread_.run(
        [c = connection_, s = settings_, exposure](const std::stop_token& stop) {
          try {
            if (!c->body) c->open(s);
            c->body->stop_with(stop);
            c->take(exposure, s, stop);
          } catch (const DeviceError& e) {
            // After these it may be out of step with us: it is opened anew.
            if (e.kind() == Kind::kProtocol || e.kind() == Kind::kTimeout ||
                e.kind() == Kind::kDisconnected)
              c->body.reset();
            throw;
          }
        },
        deadline);
    shot = connection_->shot;
  } catch (const DeviceError& e) {
    lost_ = e.kind() == Kind::kDisconnected;
    timed_out_ = e.kind() == Kind::kTimeout;
    throw;
  }
  RawFrame frame;
  frame.camera_serial = identity_.serial;
  frame.exposure = Duration::of(exposure.seconds);
  frame.triggered_ns = shot->triggered_ns;
  frame.file_type = file_type_of(shot->name);
  try {
    const CameraRaw raw = decode_camera_raw(shot->file, shot->name);
    frame.mosaic = raw.mosaic;
    if (raw.exposure_s > 0) frame.exposure = Duration::of(raw.exposure_s);
    if (raw.iso > 0) frame.gain = raw.iso / kIso;
    if (!raw.serial.empty()) frame.camera_serial = raw.serial;
  } catch (const FileError& e) {
    throw DeviceError(Kind::kFault, std::string("the camera's picture cannot be used: ") + e.what(),
                      "take it again");
  }
  if (stops_apart(frame.exposure.value(), exposure.seconds) > kSixthStop)
    throw DeviceError(Kind::kFault,
                      fmt::format("the camera exposed for {} s instead of {} s",
                                  frame.exposure.value(), exposure.seconds),
                      "set it to manual exposure");
  if (frame.gain != 1)
    throw DeviceError(Kind::kFault, fmt::format("the camera used ISO {}", kIso * frame.gain),
                      "set it to ISO 100");
  frame.file = std::move(shot->file);
  return frame;
}

std::vector<StillCameraFound> list_still_cameras() {
  std::vector<StillCameraFound> out;
  for (const GphotoPort& port : gphoto_ports()) {
    StillCameraFound found{port.model, port.address, "", ""};
    try {
      if (port.can_capture)
        found.serial = GphotoBody(port, Duration::of(1)).value("serialnumber");
      else
        found.trouble = "wrong USB mode: set it to PC Remote";
    } catch (const Error& e) {
      found.trouble = e.what();
    }
    out.push_back(std::move(found));
  }
  return out;
}

}  // namespace wheatstone
