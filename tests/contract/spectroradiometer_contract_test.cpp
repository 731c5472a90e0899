// What every spectroradiometer promises, whatever it is made of.

#include <gmock/gmock.h>

#include <limits>
#include <thread>

#include "core/error.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/resources.h"
#include "tests/contract/spectroradiometer_backends.h"

namespace wheatstone {
namespace {

using enum DeviceError::Kind;

struct Maker {
  const char* name;
  std::unique_ptr<MeterBackend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class SpectroradiometerContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { MeterBackend::prepare(); }
  Spectroradiometer& meter() { return backend_->meter(); }
  Deadline in(double s) { return backend_->clock().in(Duration::of(s)); }
  SpectralReading measure() { return meter().measure(in(200)); }

  ResourceWatch resources_;
  std::unique_ptr<MeterBackend> backend_ = GetParam().make();
};

TEST_P(SpectroradiometerContract, SaysWhoItIs) {
  EXPECT_FALSE(meter().identity().driver.empty());
}

TEST_P(SpectroradiometerContract, SeesTheLightOfTheBox) {
  for (const double drive : {0.5, 0.05}) {
    backend_->light(drive);
    const SpectralReading r = measure();
    EXPECT_NEAR(r.xyz_cd_m2.y(), backend_->truth_cd_m2(), 0.02 * backend_->truth_cd_m2());
    EXPECT_EQ(r.xyz_cd_m2, xyz_cd_m2(r.spectrum));
    ASSERT_TRUE(r.device_xyz_cd_m2);
    EXPECT_TRUE(agree(r.xyz_cd_m2, *r.device_xyz_cd_m2));
    EXPECT_FALSE(r.below_floor);
  }
}

TEST_P(SpectroradiometerContract, SpectraCoverItsRange) {
  const SpectralReading r = measure();
  const SpectroradiometerRange range = meter().range();
  EXPECT_EQ(r.spectrum.first_nm, range.first_nm);
  EXPECT_EQ(r.spectrum.step_nm, range.step_nm);
  EXPECT_DOUBLE_EQ(
      r.spectrum.first_nm + static_cast<double>(r.spectrum.values.size() - 1) * range.step_nm,
      range.last_nm);
  EXPECT_GT(range.floor_cd_m2, 0);
  EXPECT_GT(range.longest_integration.value(), 0);
}

TEST_P(SpectroradiometerContract, SaysWhenThereIsTooLittleLight) {
  backend_->light(1e-4);
  ASSERT_LT(backend_->truth_cd_m2(), meter().range().floor_cd_m2);
  EXPECT_TRUE(measure().below_floor);
}

TEST_P(SpectroradiometerContract, RefusesSettingsThatCannotBe) {
  using Settings = Spectroradiometer::Settings;
  Settings bad[6];
  bad[0].longest_integration = {};
  bad[1].longest_integration = Duration::of(std::numeric_limits<double>::quiet_NaN());
  bad[2].longest_integration = Duration::of(1e6);
  bad[3].average = 0;
  bad[4].synchronise_to = Duration::of(-1);
  bad[5].synchronise_to = Duration::of(1e-6);
  for (const Settings& settings : bad)
    EXPECT_EQ(kind_of([&] { meter().configure(settings, in(1)); }), kOutOfRange);
  measure();
}

TEST_P(SpectroradiometerContract, AveragesAndIntegratesAsItIsTold) {
  Spectroradiometer::Settings settings;
  settings.average = 3;
  meter().configure(settings, in(1));
  EXPECT_NEAR(measure().xyz_cd_m2.y(), backend_->truth_cd_m2(), 0.02 * backend_->truth_cd_m2());
  settings.longest_integration = Duration::of(0.5);
  settings.synchronise_to = Duration::of(1.0 / 60);
  const auto end = kind_of([&] { meter().configure(settings, in(1)); });
  if (backend_->chooses_its_integration()) {
    EXPECT_EQ(end, kOutOfRange);
  } else {
    EXPECT_EQ(end, std::nullopt);
    backend_->light(1e-5);  // half a second is not enough for it
    EXPECT_EQ(kind_of([&] { measure(); }), kTooDark);
  }
}

TEST_P(SpectroradiometerContract, TheAimingLightCanBeLeftOn) {
  const auto end = kind_of([&] { meter().aim(true, in(1)); });
  EXPECT_TRUE(end == std::nullopt || end == kRefused) << "it has none";
  EXPECT_NEAR(measure().xyz_cd_m2.y(), backend_->truth_cd_m2(), 0.02 * backend_->truth_cd_m2());
  meter().aim(false, in(1));
}

TEST_P(SpectroradiometerContract, KeepsDeadlinesAndStopsOnRequest) {
  meter();
  EXPECT_EQ(kind_of([&] { meter().measure(in(0)); }), kTimeout);
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(meter().measure({in(1).at_ns, asked.get_token()}), Cancelled);
  EXPECT_NEAR(measure().xyz_cd_m2.y(), backend_->truth_cd_m2(), 0.02 * backend_->truth_cd_m2())
      << "it works after both";
}

TEST_P(SpectroradiometerContract, AbortBeforeAndAfterDoesNoHarm) {
  meter().abort();
  measure();
  meter().abort();
  measure();
}

TEST_P(SpectroradiometerContract, StaysGoneOnceItIsGone) {
  if (!backend_->can_be_unplugged()) GTEST_SKIP() << "it has no line of its own";
  measure();
  backend_->unplug();
  EXPECT_EQ(kind_of([&] { measure(); }), kDisconnected);
  EXPECT_EQ(kind_of([&] { measure(); }), kDisconnected);
  EXPECT_EQ(kind_of([&] { meter().aim(false, in(1)); }), kDisconnected);
}

template <class B>
std::unique_ptr<MeterBackend> make() {
  return std::make_unique<B>();
}
const Maker kMakers[] = {
    {"Twin", make<TwinMeter>}, {"Jeti", make<JetiMeter>}, {"Spotread", make<SpotreadMeter>}};

INSTANTIATE_TEST_SUITE_P(Meters, SpectroradiometerContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

}  // namespace
}  // namespace wheatstone
