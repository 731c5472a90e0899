#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "hardware/hid/hid_device.h"
#include "hardware/marker_lights.h"

namespace wheatstone {

/// Lights behind a HID device that says itself what is lit. Dark from construction to destruction
/// but for what set() lights. What a device does otherwise than ordered, answers in nonsense,
/// stalls or loses is tried three times. A set() that fails after its first report has gone leaves
/// the lights dark as far as the device still listens; one that all_off() overtakes ends with
/// kRefused.
class HidLights : public MarkerLights {
 public:
  ~HidLights() override;
  DeviceIdentity identity() const final { return about_.identity; }
  int count() const final { return about_.count; }
  void set(Mask, Deadline) final;
  Mask state(Deadline) final;
  void all_off() noexcept final;

 protected:
  struct About {
    DeviceIdentity identity;
    int count = 0;
    Duration settle;  // from the device's word to steady light
    std::string off;  // the report that ends all light
  };
  HidLights(std::unique_ptr<HidDevice>, About);

  HidDevice& device() { return *device_; }
  void set_identity(DeviceIdentity identity) { about_.identity = std::move(identity); }
  virtual void write(Mask wanted, const Deadline&) = 0;
  /// What is lit as the device says. Throws kProtocol, kFault.
  virtual Mask read(const Deadline&) = 0;

 private:
  void begin(const Deadline&);
  void settle(const Deadline&);

  About about_;
  std::unique_ptr<HidDevice> device_;
  std::optional<Mask> steady_;  // what is known to be lit, without a flicker left
};

}  // namespace wheatstone
