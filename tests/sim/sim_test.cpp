#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "sim/camera.h"
#include "sim/observer.h"
#include "sim/simulated_rig.h"

namespace wheatstone {
namespace {

constexpr double kTestScale = 0.1;

Deadline soon(const Rig& rig) {
  return rig.clock.in(60.0_s);
}

RawFrame card_frame(std::uint64_t seed) {
  SimulatedRig twin({.scene = "card", .scale = kTestScale, .seed = seed});
  Rig rig = twin.rig();
  rig.leds->set_all(1, soon(rig));
  rig.stage->home(soon(rig));
  rig.stage->move_to(50.0_mm, soon(rig));
  return rig.camera->expose(Duration::of(1.0 / 60), soon(rig));
}

bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(SimulatedRig, RefusesUnknownScenesAndScales) {
  EXPECT_THAT([] { SimulatedRig({.scene = "moon"}); },
              testing::ThrowsMessage<ArgumentError>(testing::HasSubstr("card, sphere, objects")));
  EXPECT_THROW(SimulatedRig({.scale = 0}), ArgumentError);
  EXPECT_THROW(SimulatedRig({.scale = 1.5}), ArgumentError);
  EXPECT_THROW(SimulatedRig({.scale = std::nan("")}), ArgumentError);
}

TEST(SimulatedRig, SameSeedGivesSameBytesAtAnyThreadCount) {
  const RawFrame a = card_frame(7);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(same_bytes(a.mosaic.dn, card_frame(7).mosaic.dn));
  EXPECT_FALSE(same_bytes(a.mosaic.dn, card_frame(8).mosaic.dn));
}

TEST(SimulatedRig, BundlesAllPanelsAtTheirPlaces) {
  SimulatedRig twin({.scale = kTestScale});
  const Rig rig = twin.rig();
  for (const DisplayId id : kDisplays) {
    for (const auto m : {PanelOutput::Modulator::kLcd, PanelOutput::Modulator::kProjector}) {
      EXPECT_EQ(rig.panel(id, m).id(), id);
      EXPECT_EQ(rig.panel(id, m).modulator(), m);
    }
    EXPECT_EQ(rig.panel_models[static_cast<std::size_t>(index_of(id))].id, id);
  }
}

TEST(SimulatedStage, RefusesToLeaveItsTravelAndStands) {
  SimulatedRig twin({.scale = kTestScale});
  Rig rig = twin.rig();
  const auto kind_of = [&](Length target) {
    try {
      rig.stage->move_to(target, soon(rig));
    } catch (const DeviceError& e) {
      return e.kind();
    }
    return DeviceError::Kind::kFault;
  };
  EXPECT_EQ(kind_of(10.0_mm), DeviceError::Kind::kNotReady);
  rig.stage->home(soon(rig));
  const Length reached = rig.stage->move_to(100.0_mm, soon(rig));
  EXPECT_NEAR(reached.value(), 100, 0.025);
  EXPECT_NE(reached.value(), 100);
  EXPECT_EQ(kind_of(167.5_mm), DeviceError::Kind::kOutOfRange);
  EXPECT_EQ(kind_of(Length::of(-1)), DeviceError::Kind::kOutOfRange);
  EXPECT_EQ(twin.world().carriage_mm, reached.value());
}

TEST(SimulatedStage, TimesOutWithoutMoving) {
  SimulatedRig twin({.scale = kTestScale});
  Rig rig = twin.rig();
  rig.stage->home(soon(rig));
  EXPECT_THROW(rig.stage->move_to(100.0_mm, rig.clock.in(1.0_s)), DeviceError);
  EXPECT_EQ(twin.world().carriage_mm, 0);
}

TEST(SimulatedCamera, MarkersLieWhereThePinholeSaysTheyDo) {
  SimulatedRig twin({.scene = "objects", .scale = 0.25});
  Rig rig = twin.rig();
  rig.stage->home(soon(rig));
  for (const double target : {0.0, 83.5, 167.0}) {
    const Length at = rig.stage->move_to(Length::of(target), soon(rig));
    rig.markers->set(rig.markers->all(), soon(rig));
    const RawFrame frame = rig.camera->expose(Duration::of(1.0 / 60), soon(rig));
    double highest = 0;
    cv::minMaxLoc(frame.mosaic.dn, nullptr, &highest);
    EXPECT_LT(highest, rig.camera_profile.white_dn);
    for (const Eigen::Vector3d& p : rig.marker_positions_rsb_mm) {
      const Eigen::Vector2d q =
          project(rig.camera_profile.intrinsics, rig.camera_profile.distortion,
                  true_T_camera_rsb(at.value()) * p);
      double sum = 0, x_sum = 0, y_sum = 0;
      for (int y = int(q.y()) - 8; y <= int(q.y()) + 9; ++y) {
        for (int x = int(q.x()) - 8; x <= int(q.x()) + 9; ++x) {
          const double v = std::max(0, frame.mosaic.dn(y, x) - rig.camera_profile.black_dn - 20);
          sum += v, x_sum += v * x, y_sum += v * y;
        }
      }
      ASSERT_GT(sum, 1e4) << "marker hidden at carriage " << target;
      EXPECT_NEAR(x_sum / sum, q.x(), 0.1);
      EXPECT_NEAR(y_sum / sum, q.y(), 0.1);
    }
  }
}

TEST(SimulatedCamera, NoiseHasTheMeanAndVarianceOfTheModel) {
  SimulatedRig twin({.scale = kTestScale});
  SimulatedCamera camera(twin.world(), true);
  twin.world().light.led_drive = 1;
  const CameraProfile& p = camera.profile();
  const cv::Mat1f light = camera.optical_image_cd_m2();
  for (const double t : {1.0 / 1000, 1.0 / 60, 0.25}) {
    // Standardised residuals over photosites that cannot clip.
    double n = 0, sum = 0, squares = 0;
    const RawFrame frame = camera.expose(Duration::of(t), {Nanoseconds(1e15)});
    for (int y = 0; y < light.rows; ++y) {
      for (int x = 0; x < light.cols; ++x) {
        const double signal = p.dn_per_cd_m2_s * light(y, x) * t;
        if (signal > 14000) continue;
        const double k = p.dn_per_electron[std::size_t(bayer_colour(p.pattern, y, x))];
        const double variance =
            signal * k + (p.read_noise_e * p.read_noise_e + p.adc_noise * p.adc_noise) * k * k +
            1.0 / 12;
        const double z = (frame.mosaic.dn(y, x) - p.black_dn - signal) / std::sqrt(variance);
        ++n, sum += z, squares += z * z;
      }
    }
    ASSERT_GT(n, 1e5);
    EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n)) << t;
    EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2 / n) + 0.002) << t;
  }
}

TEST(Scene, WhiteOnTheCardIsAbout400) {
  const Scene scene("card");
  double sum = 0, low = 1e9, high = 0;
  int n = 0;
  for (float x = 120; x <= 250; x += 1.7F) {
    for (float y = 85; y <= 175; y += 1.7F) {
      const Eigen::Vector3f rgb =
          scene.radiance({{185, 130, 550}, Eigen::Vector3f(x - 185, y - 130, -549)}, {1, 0});
      sum += rgb.mean(), ++n;
      low = std::min<double>(low, rgb.minCoeff());
      high = std::max<double>(high, rgb.maxCoeff());
    }
  }
  EXPECT_NEAR(sum / n, 0.475 * kCardWhiteCdM2, 60);
  EXPECT_GT(low, 20);
  EXPECT_LT(high, 900);
  EXPECT_GT(high, 0.7 * kCardWhiteCdM2);
}

TEST(Scene, LightIsLinearInTheDriveAndLeavesTheOpening) {
  const Scene scene("sphere");
  const Ray at_sphere{{185, 130, 850}, {0, -10, -700}};
  const Eigen::Vector3f full = scene.radiance(at_sphere, {1, 0});
  EXPECT_GT(full.minCoeff(), 5);
  EXPECT_LT((scene.radiance(at_sphere, {0.5, 0}) - 0.5F * full).norm(), 1e-3F * full.norm());
  EXPECT_EQ(scene.radiance(at_sphere, {0, 15}).norm(), 0);
  EXPECT_EQ(scene.radiance({{185, 130, 300}, {0, 0, 1}}, {1, 15}).norm(), 0);
  // The floor under the sphere lies in its shadow; without the sphere it is brighter.
  const Scene without("card");
  const Ray down{{185, 40, 150}, {0, -1, 0}};
  EXPECT_LT(scene.radiance(down, {1, 0}).mean(), 0.9F * without.radiance(down, {1, 0}).mean());
}

TEST(Scene, TheFrontObjectHidesTheOthers) {
  const Scene scene("objects");
  const Eigen::Vector3f eye(185, 130, 850);
  // Through the front box's centre: the same light with and without anything behind.
  const Eigen::Vector3f hit(190, 128, 280);
  const Eigen::Vector3f seen = scene.radiance({eye, hit - eye}, {1, 0});
  const Eigen::Vector3f near_by =
      scene.radiance({hit + Eigen::Vector3f(0, 0, 1), {0, 0, -1}}, {1, 0});
  EXPECT_LT((seen - near_by).norm(), 1e-2F * near_by.norm());
  EXPECT_GT(seen.minCoeff(), 1);
}

TEST(Panels, FullWhiteReachesThePeakAndBlackOnlyLeaks) {
  SimulatedRig twin({.scale = kTestScale});
  Rig rig = twin.rig();
  const DisplayId id{Eye::kRight, Plane::kFar};
  const auto median_of = [](const RgbImage& image) {
    return image.pixels(image.height() / 2, image.width() / 2)[1];
  };
  const EyeCamera camera{64, 48, 3};
  const double black = median_of(twin.eye().photograph_displays(Eye::kRight, camera));
  EXPECT_NEAR(black, 2 * (3000.0 / 1000 / 2000 + 0.005), 1e-4);

  PanelOutput& lcd = rig.panel(id, PanelOutput::Modulator::kLcd);
  PanelOutput& projector = rig.panel(id, PanelOutput::Modulator::kProjector);
  lcd.show({cv::Mat(lcd.height_px(), lcd.width_px(), CV_8UC3, cv::Scalar::all(255))}, 0);
  const auto record = projector.show(
      {cv::Mat(projector.height_px(), projector.width_px(), CV_8UC1, cv::Scalar(255))}, 1'000'000);
  EXPECT_TRUE(!record.late && record.achieved_ns >= record.asked_ns);
  const RgbImage lit = twin.eye().photograph_displays(Eye::kRight, camera);
  EXPECT_NEAR(median_of(lit), 3000, 3);
  EXPECT_NEAR(median_of(twin.eye().photograph_displays(Eye::kLeft, camera)), black, 1e-6);
  // The projector overfills the LCD: even the corners are fully lit.
  const RgbImage light = twin.world().panel_light(id);
  for (const int y : {0, light.height() - 1}) {
    for (const int x : {0, light.width() - 1}) EXPECT_GT(light.pixels(y, x)[0], 2800);
  }
  EXPECT_THROW(lcd.show({cv::Mat1b(3, 3)}, 0), DeviceError);
}

TEST(Panels, APointOnTheFarPlaneIsSeenAtItsPixelOfTheEye) {
  const EyeCamera camera{512, 384, 1};
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    const PanelModel far = true_panel_model({eye, Plane::kFar}, 0.25);
    const Eigen::Vector2d q = project(EyePhotograph::intrinsics(eye, camera), {},
                                      EyePhotograph::T_eye_rsb(eye) * Eigen::Vector3d(150, 99, 0));
    EXPECT_LT((q - lcd_px_at(far, 150, 99)).norm(), 1e-9);
  }
}

TEST(Observer, IsUnbiasedWithTheStatedError) {
  SimulatedRig twin({.scale = 0.25, .observer_noise_arcmin = 0.3});
  World& world = twin.world();
  SimulatedObserver observer(world, 0.3);
  const DisplayId id{Eye::kLeft, Plane::kNear};
  const Eigen::Vector3d p(185, 130, 0.2);
  const Eigen::Vector2d truth = observer.true_lcd_px(id, p);
  const double sigma_px = 490 * std::tan(0.3 / 60 * M_PI / 180) / kPanelWidthMm * 512;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), squares = Eigen::Vector2d::Zero();
  constexpr int kTrials = 4000;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Vector2d d = observer.align(id, p, world.clock.in(6.0_s)) - truth;
    mean += d / kTrials;
    squares += d.cwiseProduct(d) / kTrials;
  }
  EXPECT_LT(mean.norm(), 5 * sigma_px / std::sqrt(kTrials));
  EXPECT_NEAR(std::sqrt(squares.x()) / sigma_px, 1, 0.06);
  EXPECT_NEAR(std::sqrt(squares.y()) / sigma_px, 1, 0.06);
}

TEST(Observer, EveryMarkerAndCrossCanBeAlignedOnSomeDisplay) {
  SimulatedRig twin({.scale = 0.25, .observer_noise_arcmin = 0});
  Rig rig = twin.rig();
  for (const DisplayId id : kDisplays) {
    const auto& points = rig.marker_positions_rsb_mm;
    for (const Eigen::Vector3d& p : points) EXPECT_NO_THROW(rig.observer->align(id, p, soon(rig)));
    for (const Eigen::Vector3d& p : rig.near_cross_positions_rsb_mm) {
      EXPECT_NO_THROW(rig.observer->align(id, p, soon(rig))) << to_string(id);
    }
  }
}

}  // namespace
}  // namespace wheatstone
