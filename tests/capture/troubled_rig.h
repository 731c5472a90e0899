#pragma once
// The simulated rig with devices that can go wrong on cue and that watch each other.

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/simulated_rig.h"

namespace wheatstone {

/// What a test has seen and what it lets happen. Frames and moves are counted over the object's
/// life, from 0.
class TroubledRig {
 public:
  explicit TroubledRig(const SimulatedRigOptions& options = {"card", 0.05, 7})
      : twin_(options), stage_(*this, *twin_.rig().stage), camera_(*this, *twin_.rig().camera) {}

  /// Called with the number of the frame before it is taken; may throw.
  std::function<void(int)> before_frame;
  /// May change what the camera hands over.
  std::function<void(int, RawFrame&)> after_frame;
  /// Called with the number of the move before it begins; may throw.
  std::function<void(int)> before_move;
  /// May change where the carriage says that it stands.
  std::function<Length(int, Length)> after_move;

  /// What the camera says that its own files need; 0: as the twin's.
  std::uintmax_t file_bytes = 0;

  int frames = 0, moves = 0;
  bool moved_with_open_shutter = false;
  std::vector<double> reached_mm;  // of every move

  Rig rig() {
    Rig r = twin_.rig();
    r.stage = stage_;
    r.camera = camera_;
    return r;
  }
  World& world() { return twin_.world(); }
  bool dark() { return twin_.world().light == BoxLight{}; }

 private:
  class Stage final : public LinearStage {
   public:
    Stage(TroubledRig& owner, LinearStage& stage) : owner_(owner), stage_(stage) {}
    DeviceIdentity identity() const override { return stage_.identity(); }
    Length travel() const override { return stage_.travel(); }
    Length resolution() const override { return stage_.resolution(); }
    Duration home_duration() const override { return stage_.home_duration(); }
    StageState state() const override { return stage_.state(); }
    Length position(Deadline deadline) override { return stage_.position(deadline); }
    bool position_is_measured() const override { return stage_.position_is_measured(); }
    Duration move_duration(Length d) const override { return stage_.move_duration(d); }
    Length home(Deadline deadline) override {
      owner_.watch_move();
      return stage_.home(deadline);
    }
    Length move_to(Length target, Deadline deadline) override {
      const int n = owner_.moves++;
      if (owner_.before_move) owner_.before_move(n);
      owner_.watch_move();
      const Length reached = stage_.move_to(target, deadline);
      owner_.reached_mm.push_back(reached.value());
      return owner_.after_move ? owner_.after_move(n, reached) : reached;
    }
    void stop() noexcept override { stage_.stop(); }

   private:
    TroubledRig& owner_;
    LinearStage& stage_;
  };

  class Camera final : public StillCamera {
   public:
    Camera(TroubledRig& owner, StillCamera& camera) : owner_(owner), camera_(camera) {}
    DeviceIdentity identity() const override { return camera_.identity(); }
    Duration offered_exposure(Duration exposure) const override {
      return camera_.offered_exposure(exposure);
    }
    void abort() noexcept override { camera_.abort(); }
    Duration frame_duration(Duration exposure) const override {
      return camera_.frame_duration(exposure);
    }
    std::uintmax_t largest_file(std::uintmax_t photosites) const override {
      return owner_.file_bytes ? owner_.file_bytes : camera_.largest_file(photosites);
    }
    RawFrame expose(Duration exposure, Deadline deadline) override {
      const int n = owner_.frames++;
      owner_.closed_ns_ = owner_.world().clock.in(exposure).at_ns;
      if (owner_.before_frame) owner_.before_frame(n);
      RawFrame frame = camera_.expose(exposure, deadline);
      if (owner_.after_frame) owner_.after_frame(n, frame);
      return frame;
    }

   private:
    TroubledRig& owner_;
    StillCamera& camera_;
  };

  void watch_move() {
    if (world().clock.now_ns() < closed_ns_) moved_with_open_shutter = true;
  }

  SimulatedRig twin_;
  Nanoseconds closed_ns_ = 0;  // when the shutter that was opened last is closed
  Stage stage_;
  Camera camera_;
};

}  // namespace wheatstone
