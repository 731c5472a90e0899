#pragma once
// Everything that is a spectroradiometer, for tests that do not know which.

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "hardware/argyll/spotread.h"
#include "hardware/serial/jeti.h"
#include "sim/spectroradiometer.h"
#include "sim/wire/jeti_firmware.h"
#include "sim/wire/pty_peer.h"
#include "sim/world.h"
#include "tests/contract/warm_up.h"
#include "tests/temporary_folder.h"

namespace wheatstone {

class MeterBackend {
 public:
  virtual ~MeterBackend() = default;
  virtual Spectroradiometer& meter() = 0;
  virtual Clock& clock() = 0;
  /// The next readings are of this light of the box.
  virtual void light(double led_drive) {
    const std::lock_guard lock(world_.mutex);
    world_.light.led_drive = led_drive;
  }
  virtual void unplug() = 0;
  virtual bool can_be_unplugged() const { return true; }
  virtual bool chooses_its_integration() const { return false; }
  /// A measurement takes so long that another thread can end it.
  virtual bool takes_real_time() const { return true; }
  World& world() { return world_; }
  static void prepare() { warm_up(shared_world()); }
  double truth_cd_m2() {
    return xyz_cd_m2(spectrum_of(SpectroradiometerModel(world_).rgb_cd_m2())).y();
  }

 protected:
  MeterBackend() {
    world_.light.led_drive = 0.5;
    world_.faults.reconnect("spectroradiometer");
  }
  /// Making one takes long.
  static World& shared_world() {
    static World world("card", 0.02, 7);
    return world;
  }
  World& world_ = shared_world();
};

class TwinMeter final : public MeterBackend {
 public:
  explicit TwinMeter(double gain = 1) : meter_(world_, {}, gain) {}
  SimulatedSpectroradiometer& meter() override { return meter_; }
  Clock& clock() override { return world_.clock; }
  void unplug() override {
    world_.faults.arm("spectroradiometer", DeviceError::Kind::kDisconnected);
  }
  bool takes_real_time() const override { return false; }

 private:
  SimulatedSpectroradiometer meter_;
};

/// The emulated device is two hundred times as fast as a real one.
class JetiMeter final : public MeterBackend {
 public:
  explicit JetiMeter(double gain = 1) : firmware_(world_, gain) {}
  Jeti& meter() override {
    if (!meter_) meter_ = std::make_unique<Jeti>(settings());
    return *meter_;
  }
  JetiSettings settings() const {
    JetiSettings s;
    s.line = peer_.path();
    s.baud = 921600;
    s.serial = "1211042";
    s.quiet = Duration::of(0.03);
    return s;
  }
  Clock& clock() override { return clock_; }
  void unplug() override { peer_.unplug(); }
  void close() { meter_.reset(); }
  PtyPeer& peer() { return peer_; }
  JetiFirmware& firmware() { return firmware_; }

 private:
  SteadyClock clock_;
  JetiFirmware firmware_;
  PtyPeer peer_{firmware_, {}, 200};
  std::unique_ptr<Jeti> meter_;
};

/// A shell script that takes the arguments of spotread 2.3.1 and prints and writes as it does.
class SpotreadMeter final : public MeterBackend {
 public:
  SpotreadMeter() {
    std::ofstream(script()) << "#!/bin/sh\n"
                               "cd \"$(dirname \"$0\")\"\n"
                               "echo \"$@\" > arguments\n"
                               "[ -e trouble ] && . ./trouble\n"
                               "while [ $# -gt 1 ]; do shift; done\n"
                               "cp reading.sp \"$1\"\n"
                               "cat output\n";
    std::filesystem::permissions(script(), std::filesystem::perms::owner_all);
    write_reading();
  }
  Spotread& meter() override {
    if (!meter_) meter_ = std::make_unique<Spotread>(settings());
    return *meter_;
  }
  SpotreadSettings settings() const { return {script().string(), 2}; }
  Clock& clock() override { return clock_; }
  void light(double led_drive) override {
    MeterBackend::light(led_drive);
    write_reading();
  }
  void unplug() override {}
  bool can_be_unplugged() const override { return false; }  // spotread waits for it for ever
  bool chooses_its_integration() const override { return true; }
  /// Shell commands that run before it reads; empty: none.
  void trouble(const std::string& commands) {
    std::filesystem::remove(folder_.path / "trouble");
    if (!commands.empty()) std::ofstream(folder_.path / "trouble") << commands << "\n";
  }
  std::filesystem::path script() const { return folder_.path / "spotread"; }
  std::filesystem::path folder() const { return folder_.path; }

  void write_reading() {
    const SpectralRadiance s = spectrum_of(SpectroradiometerModel(world_).rgb_cd_m2());
    std::string fields, data;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      fields += fmt::format("SPEC_{:.0f} ", s.first_nm + static_cast<double>(i) * s.step_nm);
      data += fmt::format("{:.6f} ", 1000 * s.values[i]);
    }
    std::ofstream(folder_.path / "reading.sp")
        << "SPECT\n\nDESCRIPTOR \"Argyll Spectral power/reflectance information\"\n"
           "ORIGINATOR \"Argyll CMS\"\nKEYWORD \"MEAS_TYPE\"\nMEAS_TYPE \"EMISSION\"\n"
           "KEYWORD \"SPECTRAL_BANDS\"\nSPECTRAL_BANDS \""
        << s.values.size()
        << "\"\nKEYWORD \"SPECTRAL_START_NM\"\nSPECTRAL_START_NM \"380.000000\"\n"
           "KEYWORD \"SPECTRAL_END_NM\"\nSPECTRAL_END_NM \"780.000000\"\n"
           "KEYWORD \"SPECTRAL_NORM\"\nSPECTRAL_NORM \"1.000000\"\n\nNUMBER_OF_FIELDS "
        << s.values.size() << "\nBEGIN_DATA_FORMAT\n"
        << fields << "\nEND_DATA_FORMAT\n\nNUMBER_OF_SETS 1\nBEGIN_DATA\n"
        << data << "\nEND_DATA\n";
    const Eigen::Vector3d xyz = xyz_cd_m2(s);
    std::ofstream(folder_.path / "output")
        << fmt::format("\n Result is XYZ: {:f} {:f} {:f}, Yxy: {:f} {:f} {:f}\n", xyz.x(), xyz.y(),
                       xyz.z(), xyz.y(), xyz.x() / xyz.sum(), xyz.y() / xyz.sum());
  }

 private:
  SteadyClock clock_;
  TemporaryFolder folder_;
  std::unique_ptr<Spotread> meter_;
};

}  // namespace wheatstone
