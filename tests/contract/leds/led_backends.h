#pragma once
// Everything that is an LED array and needs no umockdev, for tests that do not know which: the
// twin, and the E1.31 driver with an emulated controller.

#include <cmath>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "hardware/network/e131_led_array.h"
#include "sim/lights.h"
#include "sim/wire/e131_receiver.h"
#include "sim/world.h"

namespace wheatstone {

class LedBackend {
 public:
  explicit LedBackend(World& world) : world_(world) { world_.light = {}; }
  virtual ~LedBackend() = default;
  virtual LedArray& leds() = 0;
  virtual void close() {}  // destroys leds(), where it is a driver
  virtual Clock& clock() = 0;
  virtual void unplug() = 0;

  double light() {
    const std::lock_guard lock(world_.mutex);
    return world_.light.led_drive;
  }
  /// What is sent takes its time: whether the light becomes this.
  bool shows(double light_expected, double tolerance = 0.01) {
    SteadyClock clock;
    const Nanoseconds end = clock.in(Duration::of(1)).at_ns;
    while (std::abs(light() - light_expected) > tolerance) {
      if (clock.now_ns() > end) return false;
      clock.wait_until(clock.now_ns() + 500'000);
    }
    return true;
  }
  World& world() { return world_; }

 protected:
  World& world_;
};

/// For one backend after the other; it takes a while to build.
inline World& led_world() {
  static World world("card", 0.02, 7);
  return world;
}

class TwinLedBackend final : public LedBackend {
 public:
  TwinLedBackend() : LedBackend(led_world()) {}
  ~TwinLedBackend() override { world_.faults.reconnect("leds"); }
  LedArray& leds() override { return leds_; }
  Clock& clock() override { return world_.clock; }
  void unplug() override { world_.faults.arm("leds", DeviceError::Kind::kDisconnected); }

 private:
  SimulatedLeds leds_{world_};
};

/// A mapping that has nothing in common with the order of the LEDs.
inline LedMapping odd_mapping() {
  LedMapping m;
  m.corner = "front-right";
  m.along_rows = false;
  return m;
}

class E131Backend final : public LedBackend {
 public:
  E131Backend() : LedBackend(led_world()) {}
  LedArray& leds() override {
    if (!leds_) leds_ = std::make_unique<E131LedArray>(settings());
    return *leds_;
  }
  void close() override { leds_.reset(); }
  Clock& clock() override { return clock_; }
  void unplug() override { receiver_.switch_off(); }

  E131Settings settings() const {
    E131Settings s;
    s.address = "127.0.0.1";
    s.port = receiver_.port();
    s.first_universe = 7;
    s.mapping = odd_mapping();
    s.response_gamma = {2, 2, 2};
    s.max_mean_drive = 0.75;
    s.keep_alive = Duration::of(0.1);
    return s;
  }
  E131Receiver& receiver() { return receiver_; }
  LedCeiling& ceiling() { return ceiling_; }

 private:
  SteadyClock clock_;
  LedCeiling ceiling_{world_, places_on_wire(odd_mapping()), {2, 2, 2}};
  E131Receiver receiver_{ceiling_, 7, 2};
  std::unique_ptr<E131LedArray> leds_;
};

}  // namespace wheatstone
