#pragma once
// A camera body as libgphoto2 shows it, with our errors. All calls on one thread.

#include <gphoto2/gphoto2-camera.h>

#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "hardware/device.h"
#include "hardware/still/gphoto_camera.h"

namespace wheatstone {

/// What detection finds on the bus, unopened.
struct GphotoPort {
  std::string model, address;  // "usb:001,005"
  bool can_capture = false;
};
std::vector<GphotoPort> gphoto_ports();

/// Whether there is a device at this address.
bool plugged_in(const std::string& address);

/// Open from construction to destruction.
class GphotoBody {
 public:
  /// `usb_patience`: with one transfer; what takes as long and fails counts as silence. Throws
  /// kNotFound, kBusy, kPermission, kTimeout, kProtocol, kDisconnected.
  GphotoBody(const GphotoPort&, Duration usb_patience);
  ~GphotoBody();
  GphotoBody(const GphotoBody&) = delete;
  GphotoBody& operator=(const GphotoBody&) = delete;

  /// Long calls are broken off where libgphoto2 asks for it.
  void stop_with(std::stop_token token) { stop_ = std::move(token); }

  const std::string& address() const { return port_.address; }
  bool has(const std::string& setting);
  /// As text, as the body has it now.
  std::string value(const std::string& setting);
  std::vector<std::string> choices(const std::string& setting);
  void set(const std::string& setting, const std::string& value);

  /// kRefused: its card is full.
  void trigger();
  /// Throws kDisconnected.
  void require_plugged_in();
  /// Waits that long for the next picture; nothing: none came.
  std::optional<CameraFilePath> next_picture(Duration);
  std::vector<std::byte> fetch(const CameraFilePath&);
  /// From the card, if it was stored there, and from libgphoto2's memory.
  void remove(const CameraFilePath&);

 private:
  struct Deleter {
    void operator()(GPContext*) const;
    void operator()(Camera*) const;
    void operator()(CameraWidget*) const;
  };
  using Widget = std::unique_ptr<CameraWidget, Deleter>;

  Widget widget(const std::string& setting);
  bool card_is_full();
  void begin() { began_ns_ = SteadyClock().now_ns(); }
  /// Throws what a result below 0 means; `doing` completes "<camera> cannot ...".
  void require(int result, const std::string& doing);
  [[noreturn]] void fail(int result, const std::string& doing);

  GphotoPort port_;
  Nanoseconds patience_ns_ = std::numeric_limits<Nanoseconds>::max();  // once it is open
  Nanoseconds began_ns_ = 0;                                           // the call under way
  std::stop_token stop_;
  std::string said_;  // by libgphoto2, of the last error
  std::unique_ptr<GPContext, Deleter> context_;
  std::unique_ptr<Camera, Deleter> camera_;
};

}  // namespace wheatstone
