// A stage tracks in any order of start: controller first, twin first, nodes one after another. One twin for
// each axis gives the same result as one twin for both. A node that reboots behaves as at its first start.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/fault_rig.h"

namespace hystcan::twin {
inline void PrintTo(Node node, std::ostream* out) { *out << to_string(node); }
}  // namespace hystcan::twin

namespace hystcan::support::twin_start_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using std::chrono::seconds;
using twin::Fault;
using twin::Node;

const config::Config& shipped() {
  static const config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  return config;
}

/// The controller of both axes, and twins that start one by one.
class StartSequence {
 public:
  void start_controller() { controller_.start(); }
  void start_twin(const twin::Config& config) {
    twins_.push_back(std::make_unique<twin::Twin>(
        config, shipped().database, clock_,
        [this](std::span<const can::Filter>) { return bus_.attach(can::TransmitOrder::by_priority); }));
    twins_.back()->start();
  }
  void run_for(can::Duration time) { clock_.run_until(clock_.now() + time); }
  bool track() {
    for (int i = 0; i < 100; ++i) {
      run_for(milliseconds(50));
      if (controller_.axis(0).state() == AxisState::tracking &&
          controller_.axis(1).state() == AxisState::tracking)
        return true;
    }
    return false;
  }

  std::vector<double> positions_um;  ///< positions of both axes, cycle by cycle

 private:
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, shipped().bus.rates()};
  controller::Controller controller_{
      controller_config(shipped()), shipped().database, clock_,
      [this](std::span<const can::Filter>) { return bus_.attach(); },
      [this](const controller::CycleRecord& record) { positions_um.push_back(record.report.position_um); }};
  std::vector<std::unique_ptr<twin::Twin>> twins_;
};

TEST(StartUp, TracksWhenOneAxisStartsAfterTheOther) {
  StartSequence sequence;
  sequence.start_twin(with_axes(twin_config(shipped()), {"y"}));
  sequence.start_controller();
  sequence.run_for(seconds(2));
  sequence.start_twin(with_axes(twin_config(shipped()), {"x"}));
  EXPECT_TRUE(sequence.track());
}

/// The nodes of both axes are off at first; the second nodes stay off longer.
TEST(StartUp, TracksWhenOneNodeStartsAfterTheOther) {
  for (const bool sensors_first : {true, false}) {
    twin::Config config = twin_config(shipped());
    for (const char* axis : {"x", "y"})
      for (const Node node : {Node::sensor, Node::amplifier}) {
        twin::FaultSpec spec = twin::fault_spec(Fault::node_reboot, axis);
        spec.node = node;
        const bool is_first = (node == Node::sensor) == sensors_first;
        spec.lasts = seconds(is_first ? 1 : 2);
        config.faults.push_back(spec);
      }
    StartSequence sequence;
    sequence.start_controller();
    sequence.start_twin(config);
    sequence.run_for(milliseconds(1500));
    EXPECT_TRUE(sequence.track()) << "sensors first: " << sensors_first;
  }
}

TEST(SeveralTwins, GiveTheSameBitsAsOneTwinOfBothAxes) {
  StartSequence one;
  one.start_twin(twin_config(shipped()));
  StartSequence two;
  two.start_twin(with_axes(twin_config(shipped()), {"x"}));
  two.start_twin(with_axes(twin_config(shipped()), {"y"}));
  for (StartSequence* sequence : {&one, &two}) {
    sequence->start_controller();
    sequence->run_for(seconds(3));
  }
  ASSERT_GT(one.positions_um.size(), 4000u);
  EXPECT_EQ(one.positions_um, two.positions_um);
}

TEST(SeveralTwins, RefuseAnAxisThatDoesNotExist) {
  EXPECT_THROW(with_axes(twin_config(shipped()), {"x", "z"}), std::invalid_argument);
  twin::Config config = twin_config(shipped());
  config.faults = {twin::fault_spec(Fault::no_reply, "x"), twin::fault_spec(Fault::no_reply, "y")};
  EXPECT_EQ(with_axes(config, {"y"}).faults.size(), 1u) << "the other fault belongs to the other twin";
}

class NodeReboot : public testing::TestWithParam<Node> {};

/// A reboot removes objects written by SDO and a latched fault. The controller sets the node up before it
/// drives it.
TEST_P(NodeReboot, ResetsTheNodeAndRepeatsItsSetUp) {
  constexpr can::SdoObject object{.index = 0x2001, .subindex = 1};
  config::Config config = one_axis();
  const std::vector<can::SdoWrite> setup{{.object = object, .content = {.value = 7, .bytes = 2}}};
  config.axes[0].wire.amplifier_setup = setup;
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.tracks());
  node::AmplifierChannel& amplifier = rig.stage().amplifier;
  ASSERT_TRUE(amplifier.node().objects().object(object));
  rig.run_for(milliseconds(800));

  twin::FaultSpec trip = twin::fault_spec(Fault::amplifier_trip, "x");
  rig.stage_faults().inject(trip);
  rig.run_for(milliseconds(5));
  ASSERT_EQ(amplifier.fault(), node::internal_fault);
  rig.stage_faults().remove(Fault::amplifier_trip);
  EXPECT_EQ(amplifier.fault(), node::internal_fault) << "latched";

  twin::FaultSpec reboot = twin::fault_spec(Fault::node_reboot, "x");
  reboot.node = GetParam();
  reboot.lasts = milliseconds(50);
  rig.stage_faults().inject(reboot);
  rig.run_for(milliseconds(52));
  const bool is_amplifier = GetParam() == Node::amplifier;
  EXPECT_EQ(amplifier.fault(), is_amplifier ? 0 : node::internal_fault);
  EXPECT_EQ(amplifier.node().objects().object(object).has_value(), !is_amplifier);
  EXPECT_EQ(is_amplifier ? amplifier.state() == can::AmpState::off
                         : rig.stage().sensor.node().state() == can::NmtState::pre_operational,
            true);

  ASSERT_EQ(rig.ask(controller::Request::Kind::clear), "");
  ASSERT_EQ(rig.ask(controller::Request::Kind::enable), "");
  ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  EXPECT_TRUE(amplifier.node().objects().object(object));
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

INSTANTIATE_TEST_SUITE_P(, NodeReboot, testing::Values(Node::sensor, Node::amplifier),
                         [](const auto& test) { return std::string(to_string(test.param)); });

}  // namespace
}  // namespace hystcan::support::twin_start_test
