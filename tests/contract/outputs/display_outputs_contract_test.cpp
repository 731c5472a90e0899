// What all display outputs promise, on the twin and on an X server; and every line of the tables of
// their faults, carried out.

#include <gmock/gmock.h>

#include <memory>

#include "core/error.h"
#include "core/files.h"
#include "hardware/edid.h"
#include "hardware/outputs/xrandr_driver.h"
#include "hardware/outputs/xrandr_outputs.h"
#include "hardware/rig_file/diagnosis.h"
#include "sim/display_outputs.h"
#include "tests/contract/display_outputs_faults.h"
#include "tests/contract/fault_call.h"
#include "tests/contract/outputs/x_server.h"
#include "tests/contract/resources.h"
#include "tests/contract/warm_up.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

const EdidIdentity kMonitor = {"WST", 77, 4711, "MONITOR", "SN-1"};

Deadline in(double s) {
  return SteadyClock().in(Duration::of(s));
}

class Backend {
 public:
  virtual ~Backend() = default;
  virtual DisplayOutputs& outputs() = 0;
  virtual Clock& clock() = 0;
  virtual std::vector<WantedOutput> wanted() = 0;
  virtual void unplug() = 0;
};

World& shared_world() {
  static World world("card", 0.02, 7);
  return world;
}

class TwinBackend final : public Backend {
 public:
  TwinBackend() { shared_world().faults.reconnect("display outputs"); }
  SimulatedDisplayOutputs& outputs() override { return outputs_; }
  Clock& clock() override { return shared_world().clock; }
  std::vector<WantedOutput> wanted() override { return wanted_simulated_outputs(); }
  void unplug() override { shared_world().faults.arm("display outputs", kDisconnected); }

 private:
  SimulatedDisplayOutputs outputs_{shared_world()};
};

class XBackend final : public Backend {
 public:
  XBackend() {
    server_.set_edid(compose_edid(kMonitor));
    std::vector<std::uint16_t> dimmed(256);
    for (std::size_t i = 0; i < dimmed.size(); ++i) dimmed[i] = static_cast<std::uint16_t>(200 * i);
    server_.set_gamma(dimmed);
  }
  XrandrOutputs& outputs() override {
    if (!outputs_) outputs_ = std::make_unique<XrandrOutputs>(settings(), in(2));
    return *outputs_;
  }
  XrandrSettings settings() const { return {server_.display()}; }
  Clock& clock() override { return clock_; }
  std::vector<WantedOutput> wanted() override {
    return {{"operator", kMonitor, "", 640, 480, 0, 8}};
  }
  void unplug() override { server_.kill(); }
  XServer& server() { return server_; }
  void close() { outputs_.reset(); }

 private:
  SteadyClock clock_;
  XServer server_;
  std::unique_ptr<XrandrOutputs> outputs_;
};

struct Maker {
  const char* name;
  std::unique_ptr<Backend> (*make)();
};
void PrintTo(const Maker& maker, std::ostream* out) {
  *out << maker.name;
}

class DisplayOutputsContract : public ::testing::TestWithParam<Maker> {
 protected:
  static void SetUpTestSuite() { warm_up(shared_world()); }
  Deadline soon() { return backend_->clock().in(Duration::of(2)); }

  ResourceWatch resources_;
  std::unique_ptr<Backend> backend_ = GetParam().make();
};

TEST_P(DisplayOutputsContract, SaysWhoItIs) {
  EXPECT_FALSE(backend_->outputs().identity().driver.empty());
}

TEST_P(DisplayOutputsContract, EveryDisplayHasAPlaceAndAMode) {
  const auto outputs = backend_->outputs().enumerate(soon());
  ASSERT_FALSE(outputs.empty());
  for (const DisplayOutput& o : outputs) {
    EXPECT_FALSE(o.connector.empty());
    EXPECT_FALSE(o.edid.manufacturer.empty());
    EXPECT_GT(o.width_px, 0);
    EXPECT_GT(o.height_px, 0);
    EXPECT_GE(o.bits_per_channel, 8);
    EXPECT_GE(o.gamma_size, 256);
    EXPECT_FALSE(o.is_scaled);
  }
}

TEST_P(DisplayOutputsContract, IsAsWantedOnceItsTablesAreNeutral) {
  DisplayOutputs& outputs = backend_->outputs();
  const auto before = verify(outputs.enumerate(soon()), backend_->wanted());
  ASSERT_EQ(before.size(), backend_->wanted().size());
  for (const OutputProblem& problem : before) EXPECT_EQ(problem.check, "gamma");
  outputs.neutralise(soon());
  EXPECT_THAT(verify(outputs.enumerate(soon()), backend_->wanted()), ::testing::IsEmpty());
  outputs.neutralise(soon());  // once more does no harm
}

TEST_P(DisplayOutputsContract, StopsOnRequest) {
  DisplayOutputs& outputs = backend_->outputs();
  std::stop_source asked;
  asked.request_stop();
  EXPECT_THROW(outputs.enumerate({soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_THROW(outputs.neutralise({soon().at_ns, asked.get_token()}), Cancelled);
  EXPECT_FALSE(outputs.enumerate(soon()).empty());
}

TEST_P(DisplayOutputsContract, StaysGoneOnceItIsGone) {
  DisplayOutputs& outputs = backend_->outputs();
  outputs.enumerate(soon());
  backend_->unplug();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(kind_of([&] { outputs.enumerate(soon()); }), kDisconnected);
    EXPECT_EQ(kind_of([&] { outputs.neutralise(soon()); }), kDisconnected);
  }
}

template <class B>
std::unique_ptr<Backend> make() {
  return std::make_unique<B>();
}
const Maker kMakers[] = {{"Twin", make<TwinBackend>}, {"X", make<XBackend>}};

INSTANTIATE_TEST_SUITE_P(Outputs, DisplayOutputsContract, ::testing::ValuesIn(kMakers),
                         [](const auto& maker) { return std::string(maker.param.name); });

class FaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up(shared_world()); }
  ResourceWatch resources_;
};

class XrandrFaults : public FaultTest {};

TEST_P(XrandrFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault, state = fault.state;
  if (state == "opening") {
    std::unique_ptr<XServer> server;
    XrandrSettings settings{":6543"};
    if (what == "no such name") settings.display = "no display";
    if (what == "server without RandR") {
      server = std::make_unique<XServer>(std::vector<std::string>{"-extension", "RANDR"});
      settings.display = server->display();
    }
    expect_fault(fault, [&](const Deadline& d) { XrandrOutputs(settings, d); });
    return;
  }
  XBackend backend;
  XrandrOutputs& outputs = backend.outputs();
  outputs.enumerate(in(2));
  if (what == "stall") backend.server().freeze();
  if (what == "server killed") backend.server().kill();
  expect_fault(fault, [&](const Deadline& d) {
    if (state == "enumerating")
      outputs.enumerate(d);
    else
      outputs.neutralise(d);
  });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { outputs.enumerate(in(1)); }), kDisconnected);
    return;
  }
  backend.server().thaw();
  outputs.neutralise(in(2));
  EXPECT_TRUE(outputs.enumerate(in(2))[0].gamma_is_identity);
}

INSTANTIATE_TEST_SUITE_P(Outputs, XrandrFaults, ::testing::ValuesIn(kXrandrFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class SimulatedOutputFaults : public FaultTest {};

TEST_P(SimulatedOutputFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  TwinBackend backend;
  const auto soon = [&] { return backend.clock().in(Duration::of(1)); };
  arm(shared_world().faults, "display outputs", fault);
  expect_fault(fault, [&](const Deadline&) {
    if (std::string(fault.state) == "enumerating")
      backend.outputs().enumerate(soon());
    else
      backend.outputs().neutralise(soon());
  });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { backend.outputs().enumerate(soon()); }), kDisconnected);
    shared_world().faults.reconnect("display outputs");
  }
  EXPECT_FALSE(backend.outputs().enumerate(soon()).empty());
}

INSTANTIATE_TEST_SUITE_P(Outputs, SimulatedOutputFaults,
                         ::testing::ValuesIn(kSimulatedOutputFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class XrandrOddities : public FaultTest {};

TEST_F(XrandrOddities, TablesAreRestored) {
  XBackend backend;
  const auto before = backend.server().gamma();
  backend.outputs().neutralise(in(2));
  EXPECT_TRUE(is_identity_gamma(backend.server().gamma()));
  backend.close();
  EXPECT_EQ(backend.server().gamma(), before);
}

TEST_F(XrandrOddities, DisplaysAreKnownByTheirEdid) {
  XBackend backend;
  EXPECT_EQ(backend.outputs().enumerate(in(2))[0].edid, kMonitor);
  auto damaged = compose_edid(kMonitor);
  damaged[20] ^= std::byte{1};
  backend.server().set_edid(damaged);
  const auto outputs = backend.outputs().enumerate(in(2));
  EXPECT_EQ(outputs[0].edid, EdidIdentity{});
  const auto problems = verify(outputs, backend.wanted());
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].check, "identity");
}

TEST_F(XrandrOddities, TheWayToTheDisplayIsReadBack) {
  XBackend backend;
  const auto look = [&] { return backend.outputs().enumerate(in(2))[0]; };
  EXPECT_EQ(look().dithering, "") << "this server has no such property";
  EXPECT_EQ(look().range, "");
  EXPECT_EQ(look().link_bits_per_channel, 0);
  for (const char* name : {"dither", "dithering mode"}) {  // the second is read first
    backend.server().set_choice(name, std::string(name) + " on");
    EXPECT_EQ(look().dithering, std::string(name) + " on");
  }
  backend.server().set_choice("Broadcast RGB", "Limited 16:235");
  backend.server().set_integers("max bpc", {6});
  EXPECT_EQ(look().range, "Limited 16:235");
  EXPECT_EQ(look().link_bits_per_channel, 6);
  std::vector<std::uint32_t> matrix(18);
  backend.server().set_integers("CTM", matrix);
  EXPECT_FALSE(look().has_colour_matrix) << "none is set";
  matrix[1] = matrix[9] = matrix[17] = 1;
  backend.server().set_integers("CTM", matrix);
  EXPECT_FALSE(look().has_colour_matrix);
  matrix[16] = 0x8000'0000;
  matrix[17] = 0;  // blue at half
  backend.server().set_integers("CTM", matrix);
  EXPECT_TRUE(look().has_colour_matrix);
  backend.outputs().neutralise(in(2));
  std::vector<std::string> checks;
  for (const OutputProblem& p : verify({look()}, backend.wanted())) checks.push_back(p.check);
  EXPECT_THAT(checks, ::testing::ElementsAre("dithering", "link depth", "range", "colour matrix"));
  // Of another shape than video drivers give: as if it were not there.
  backend.server().set_integers("max bpc", {6, 7});
  backend.server().set_integers("CTM", {1, 2, 3});
  EXPECT_EQ(look().link_bits_per_channel, 0);
  EXPECT_FALSE(look().has_colour_matrix);
}

TEST_F(XrandrOddities, DepthIsOfTheServer) {
  const XServer deep({"-screen", "0", "640x480x30"});
  XrandrOutputs outputs({deep.display()}, in(2));
  EXPECT_EQ(outputs.enumerate(in(2))[0].bits_per_channel, 10);
}

TEST_F(XrandrOddities, TheDiagnosisNamesEachDisplay) {
  const XBackend backend;
  const TemporaryFolder folder;
  const auto file = folder.path / "rig.toml";
  write_text_atomically(
      file,
      "schema = \"wheatstone-rig/1\"\nname = \"x\"\n[display_outputs]\ndriver = \"xrandr\"\n"
      "display = \"" +
          backend.settings().display +
          "\"\n[[output]]\nrole = \"operator\"\nmanufacturer = \"WST\"\nproduct = 77\n"
          "width_px = 800\nheight_px = 600\n[[output]]\nrole = \"left_near_lcd\"\n"
          "connector = \"DP-9\"\nwidth_px = 2048\nheight_px = 1536\n"
          "[safety]\nluminance_limit_cd_m2 = 300\n");
  DriverCatalogue catalogue;
  add_xrandr_driver(catalogue);
  const auto lines = diagnose(read_rig_file(file, catalogue));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].role, "display_outputs");
  EXPECT_EQ(lines[0].status, "ok");
  EXPECT_EQ(lines[1].status, "wrong");
  EXPECT_THAT(lines[1].problem, ::testing::HasSubstr("mode: 640 x 480 px"));
  EXPECT_EQ(lines[2].role, "output left_near_lcd");
  EXPECT_THAT(lines[2].problem, ::testing::HasSubstr("DP-9"));
}

}  // namespace
}  // namespace wheatstone
