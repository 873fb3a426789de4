// Who comes when, and how many twins there are, makes no difference to a stage: controller first, twin first,
// nodes one after another, a twin for each axis; and a node that reboots comes back as at its first start.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/fault_rig.h"

namespace hystcan::support {
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

/// The controller of both axes, and twins that are switched on one by one.
class Bench {
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

  std::vector<double> positions_um;  ///< of both axes, cycle by cycle

 private:
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, shipped().bus.bitrate_bit_per_s};
  controller::Controller controller_{
      controller_config(shipped()), shipped().database, clock_,
      [this](std::span<const can::Filter>) { return bus_.attach(); },
      [this](const controller::CycleRecord& record) { positions_um.push_back(record.report.position_um); }};
  std::vector<std::unique_ptr<twin::Twin>> twins_;
};

TEST(StartUp, OfTheTwinFirst) {
  Bench bench;
  bench.start_twin(twin_config(shipped()));
  bench.run_for(seconds(2));
  bench.start_controller();
  EXPECT_TRUE(bench.track());
}

TEST(StartUp, OfTheControllerFirst) {
  Bench bench;
  bench.start_controller();
  bench.run_for(seconds(2));
  bench.start_twin(twin_config(shipped()));
  EXPECT_TRUE(bench.track());
}

TEST(StartUp, OfOneAxisAfterTheOther) {
  Bench bench;
  bench.start_twin(with_axes(twin_config(shipped()), {"y"}));
  bench.start_controller();
  bench.run_for(seconds(2));
  bench.start_twin(with_axes(twin_config(shipped()), {"x"}));
  EXPECT_TRUE(bench.track());
}

/// Each node of the two axes is dark at first, and for longer than the one before.
TEST(StartUp, OfOneNodeAfterTheOther) {
  for (const bool sensors_first : {true, false}) {
    twin::Config config = twin_config(shipped());
    for (const char* axis : {"x", "y"})
      for (const Node node : {Node::sensor, Node::amplifier}) {
        twin::FaultSpec order = twin::fault_spec(Fault::node_reboot, axis);
        order.node = node;
        const bool is_first = (node == Node::sensor) == sensors_first;
        order.lasts = seconds(is_first ? 1 : 2);
        config.faults.push_back(order);
      }
    Bench bench;
    bench.start_controller();
    bench.start_twin(config);
    bench.run_for(milliseconds(1500));
    EXPECT_TRUE(bench.track()) << "sensors first: " << sensors_first;
  }
}

TEST(SeveralTwins, OneForEachAxisAreToTheBitTheOneOfBoth) {
  Bench one;
  one.start_twin(twin_config(shipped()));
  Bench two;
  two.start_twin(with_axes(twin_config(shipped()), {"x"}));
  two.start_twin(with_axes(twin_config(shipped()), {"y"}));
  for (Bench* bench : {&one, &two}) {
    bench->start_controller();
    bench->run_for(seconds(3));
  }
  ASSERT_GT(one.positions_um.size(), 4000u);
  EXPECT_EQ(one.positions_um, two.positions_um);
}

TEST(SeveralTwins, AreOfAxesThatThereAre) {
  EXPECT_THROW(with_axes(twin_config(shipped()), {"x", "z"}), std::invalid_argument);
  twin::Config config = twin_config(shipped());
  config.faults = {twin::fault_spec(Fault::no_reply, "x"), twin::fault_spec(Fault::no_reply, "y")};
  EXPECT_EQ(with_axes(config, {"y"}).faults.size(), 1u) << "the other is the other twin's";
}

class Reboot : public testing::TestWithParam<Node> {};

/// Objects written by SDO, a latched fault: gone. The controller sets the node up again before it drives it.
TEST_P(Reboot, ComesBackAsAtTheFirstStartAndIsSetUpAgain) {
  constexpr can::SdoObject object{.index = 0x2001, .subindex = 1};
  config::Config config = one_axis();
  const std::vector<can::SdoWrite> setup{{.object = object, .content = {.value = 7, .bytes = 2}}};
  config.axes[0].wire.amplifier_setup = setup;
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.tracks());
  twin::AmplifierNode& amplifier = rig.stage().amplifier;
  ASSERT_TRUE(amplifier.objects().object(object));
  rig.run_for(milliseconds(800));

  twin::FaultSpec trip = twin::fault_spec(Fault::amplifier_trip, "x");
  rig.stage_faults().inject(trip);
  rig.run_for(milliseconds(5));
  ASSERT_EQ(amplifier.fault(), twin::internal_fault);
  rig.stage_faults().remove(Fault::amplifier_trip);
  EXPECT_EQ(amplifier.fault(), twin::internal_fault) << "latched";

  twin::FaultSpec reboot = twin::fault_spec(Fault::node_reboot, "x");
  reboot.node = GetParam();
  reboot.lasts = milliseconds(50);
  rig.stage_faults().inject(reboot);
  rig.run_for(milliseconds(52));
  const bool is_amplifier = GetParam() == Node::amplifier;
  EXPECT_EQ(amplifier.fault(), is_amplifier ? 0 : twin::internal_fault);
  EXPECT_EQ(amplifier.objects().object(object).has_value(), !is_amplifier);
  EXPECT_EQ(is_amplifier ? amplifier.state() == can::AmpState::off
                         : rig.stage().sensor.state() == can::NmtState::pre_operational,
            true);

  ASSERT_EQ(rig.ask(controller::Request::Kind::clear), "");
  ASSERT_EQ(rig.ask(controller::Request::Kind::enable), "");
  ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  EXPECT_TRUE(amplifier.objects().object(object));
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

INSTANTIATE_TEST_SUITE_P(, Reboot, testing::Values(Node::sensor, Node::amplifier),
                         [](const auto& made_of) { return std::string(to_string(made_of.param)); });

}  // namespace
}  // namespace hystcan::support
