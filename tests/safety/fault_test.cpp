// Every cause of a fault, injected on the simulated bus between the real controller and the real twin. Each
// fault is decided in time, and the safe command is on the wire within a cycle of the deciding frame. The
// axis stays faulted until the fault is cleared, and tracks again when the trouble is over.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::fault_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;
using Kind = controller::Request::Kind;

/// The time of the command's own frame and of one frame before it; plus a cycle if the next step sends the
/// command.
double safe_within_ms(Cause cause) { return (is_between_steps(cause) ? 1.0 : 0.0) + 2 * frame_ms; }

double ms(can::Duration time) { return 1e3 * can::seconds(time); }

struct Injection {
  Trouble trouble;
  const char* promise;  ///< promise of docs/safety.md, "Faults"
  Cause cause;
  double decided_within_ms;
  bool bus_carries = true;  ///< false: commands do not reach the amplifier, so its watchdog acts
  int enable_delay_ms = 0;  ///< delay of the amplifier's relay
};
std::ostream& operator<<(std::ostream& out, const Injection& injection) {
  return out << to_string(injection.trouble);
}

// docs/safety.md derives the figures. A cycle is 1 ms, and the trouble begins at any phase of a cycle.
const std::vector<Injection> injections{
    {Trouble::sample_lost, "S-015", Cause::sample_missing, 6.0},
    {Trouble::sample_late, "S-016", Cause::sample_late, 6.0},
    {Trouble::sample_frozen, "S-019", Cause::position_frozen, 52.0},
    {Trouble::counter_frozen, "S-015", Cause::sample_missing, 6.0},
    {Trouble::sample_damaged, "S-015", Cause::sample_missing, 6.0},
    {Trouble::sample_jumped, "S-018", Cause::position_jumped, 6.0},
    {Trouble::sample_beyond, "S-020", Cause::position_implausible, 2.0},
    {Trouble::sample_bad, "S-021", Cause::sensor_status, 2.0},
    {Trouble::sensor_emergency, "S-022", Cause::node_emergency, 2.0},
    {Trouble::sensor_unheard, "S-023", Cause::sensor_silent, 302.0},
    {Trouble::amplifier_unheard, "S-024", Cause::amplifier_silent, 302.0},
    {Trouble::sensor_stopped, "S-027", Cause::foreign_access, 1.0},
    {Trouble::amplifier_stopped, "S-027", Cause::foreign_access, 1.0},
    {Trouble::foreign_write, "S-027", Cause::foreign_access, 1.0},
    {Trouble::forged_sample, "S-017", Cause::sample_doubled, 2.0},
    {Trouble::statuses_lost, "S-030", Cause::status_missing, 402.0},
    {Trouble::sensor_leaves, "S-026", Cause::node_not_operational, 102.0},
    {Trouble::sensor_reset, "S-025", Cause::node_restarted, 2.0},
    {Trouble::amplifier_reset, "S-025", Cause::node_restarted, 2.0},
    {Trouble::amplifier_trips, "S-029", Cause::amplifier_fault, 2.0},
    {Trouble::commands_lost, "S-029", Cause::amplifier_fault, 22.0},
    {Trouble::enable_lost, "S-031", Cause::amplifier_not_enabled, 3.0},
    {Trouble::bus_passive, "S-013", Cause::bus_passive, 52.0},
    {Trouble::bus_off, "S-012", Cause::bus_off, 4.0, false},
    {Trouble::interface_down, "S-011", Cause::interface_down, 2.0, false},
    {Trouble::position_drifts, "S-034", Cause::following_error, 10.0},
    {Trouble::load_pulls, "S-036", Cause::saturated, 800.0},
    {Trouble::sync_late, "S-014", Cause::cycle_overrun, 3.0},
    {Trouble::stall, "S-014", Cause::cycle_overrun, 23.0},
    {Trouble::foreign_sync, "S-041", Cause::another_controller, 1.0},
    {Trouble::foreign_heartbeat, "S-041", Cause::another_controller, 1.0},
    {Trouble::law_not_finite, "S-037", Cause::model_left_range, 5.0},
};

TEST(Injections, CoverEveryTrouble) {
  for (std::size_t i = 0; i < trouble_count; ++i)
    EXPECT_TRUE(std::ranges::any_of(injections, [&](const Injection& one) {
      return one.trouble == static_cast<Trouble>(i);
    })) << to_string(static_cast<Trouble>(i));
}

std::vector<Injection> with_a_relay(std::vector<Injection> all) {
  for (Injection& injection : all) injection.enable_delay_ms = 100;
  return all;
}

config::Config config_for(const Injection& injection) {
  config::Config config = one_axis();
  config.axes[0].twin.enable_delay = milliseconds(injection.enable_delay_ms);
  if (injection.trouble != Trouble::sample_frozen) return config;
  // A slow ramp, so that the frozen position is detected by its constant bits before the following error is
  // too large.
  config.axes[0].control.setpoint = {
      {.shape = controller::Ramp{.from_um = 5.0, .to_um = 25.0, .duration_s = 1.0}, .transition_s = 0.1}};
  return config;
}

double error_um(const FaultRig& rig) {
  const controller::AxisReport& report = rig.axis().report();
  return std::abs(report.reference_um - report.position_um);
}

class Fault : public testing::TestWithParam<Injection> {
 protected:
  void track() {
    rig.start();
    ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
    rig.run_for(milliseconds(725));  // after the transition, on a slope of the sine
    ASSERT_LT(error_um(rig), 0.5);
  }
  void inject() {
    begun = rig.clock().now();
    rig.begin(GetParam().trouble);
    rig.reaches(AxisState::faulted, milliseconds(1000));
    rig.run_for(milliseconds(2));
  }

  FaultRig rig{config_for(GetParam())};
  can::Time begun{};
};

TEST_P(Fault, IsDecidedInTimeAndFollowedByTheSafeCommand) {
  shows(std::string("S-043, S-045, ") + GetParam().promise);
  ASSERT_NO_FATAL_FAILURE(track());
  inject();
  ASSERT_EQ(to_string(rig.axis().fault().cause), to_string(GetParam().cause));
  const double decided_ms = ms(rig.decided_at() - begun);
  EXPECT_LE(decided_ms, GetParam().decided_within_ms);
  if (GetParam().bus_carries) {
    ASSERT_TRUE(rig.monitor().commands_are_safe());
    const double safe_ms = ms(rig.monitor().safe_since() - rig.decided_at());
    EXPECT_LE(safe_ms, safe_within_ms(GetParam().cause));
    std::printf("%-18s decided after %8.3f ms, safe command on the wire %6.3f ms later\n",
                std::string(to_string(GetParam().trouble)).c_str(), decided_ms, safe_ms);
  }
  rig.run_for(milliseconds(25));  // watchdog time of the amplifier, 20 ms, and its slew
  rig.stage().plant.advance_to(rig.clock().now());
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
  EXPECT_NE(rig.stage().amplifier.state(), can::AmpState::enabled);
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

TEST_P(Fault, IsLatchedUntilCleared) {
  shows("S-001, S-002, S-003");
  ASSERT_NO_FATAL_FAILURE(track());
  EXPECT_EQ(rig.ask(Kind::clear), "there is no fault to clear");
  inject();
  ASSERT_EQ(rig.axis().state(), AxisState::faulted);
  rig.end(GetParam().trouble);
  rig.run_for(milliseconds(500));
  EXPECT_EQ(rig.axis().state(), AxisState::faulted) << "only clear ends it";
  EXPECT_EQ(rig.axis().fault().cause, GetParam().cause);
  EXPECT_EQ(rig.ask(Kind::enable), "the axis is faulted: clear the fault first");
  EXPECT_EQ(rig.ask(Kind::clear), "");
  EXPECT_EQ(rig.ask(Kind::clear), "there is no fault to clear");
  rig.run_for(milliseconds(100));
  EXPECT_EQ(rig.axis().state(), AxisState::offline) << "clear does not enable the axis";
  EXPECT_EQ(rig.ask(Kind::enable), "");
  EXPECT_TRUE(rig.tracks()) << to_string(rig.axis().state()) << ", " << to_string(rig.axis().fault().cause);
  rig.run_for(milliseconds(350));
  EXPECT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
  EXPECT_LT(error_um(rig), 0.5);
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

const auto name_of = [](const auto& test) { return std::string(to_string(test.param.trouble)); };
INSTANTIATE_TEST_SUITE_P(, Fault, testing::ValuesIn(injections), name_of);
INSTANTIATE_TEST_SUITE_P(OfAnAmplifierWithARelay, Fault, testing::ValuesIn(with_a_relay(injections)),
                         name_of);

/// Troubles of up to three cycles, which must not fault the axis.
class ShortTrouble : public testing::TestWithParam<Trouble> {};

TEST_P(ShortTrouble, IsBridgedForThreeCycles) {
  shows("S-042, S-092");
  FaultRig rig(one_axis());
  rig.start();
  ASSERT_TRUE(rig.tracks());
  rig.run_for(milliseconds(400));
  for (int i = 0; i < 20; ++i) {
    rig.begin(GetParam());
    rig.run_for(milliseconds(3));
    rig.end(GetParam());
    rig.run_for(milliseconds(60));
    ASSERT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
  }
  EXPECT_EQ(rig.monitor().violations(), 0u);
}

INSTANTIATE_TEST_SUITE_P(, ShortTrouble,
                         testing::Values(Trouble::sample_lost, Trouble::counter_frozen,
                                         Trouble::sample_damaged, Trouble::sample_jumped,
                                         Trouble::sample_frozen, Trouble::commands_lost,
                                         Trouble::bus_passive),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(NodeFault, RepeatsTheSetUpAfterClear) {
  shows("S-028");
  config::Config config = one_axis();
  can::AxisWire& wire = config.axes[0].wire;
  wire.sensor_setup = {{.object = {.index = 0x1000, .subindex = 0}, .content = {.value = 1, .bytes = 4}}};
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::seconds(2)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::node_not_set_up);
  const auto sent_before = rig.controller().bus().counters().sent;
  EXPECT_EQ(rig.ask(Kind::clear), "");
  EXPECT_EQ(rig.ask(Kind::enable), "");
  rig.run_for(milliseconds(1));
  EXPECT_EQ(rig.axis().state(), AxisState::waiting) << "it is set up again first";
  ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::seconds(2)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::node_not_set_up) << "it still has no such object";
  EXPECT_GT(rig.controller().bus().counters().sent, sent_before);
  EXPECT_EQ(rig.monitor().violations(), 0u);
}

TEST(CommandFault, SendsTheSafeCommandIfADriveDoesNotFitItsSignal) {
  shows("S-038");
  config::Config config = one_axis();
  for (can::Message& message : config.database.messages)
    for (can::Signal& signal : message.signals)
      if (message.name == "XAmpCommand" && signal.name == "Setpoint") signal.maximum = 50.0;
  FaultRig rig(config);
  rig.start();
  ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::seconds(2)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::command_not_sendable);
  rig.run_for(milliseconds(2));
  EXPECT_TRUE(rig.monitor().commands_are_safe());
  EXPECT_LE(ms(rig.monitor().safe_since() - rig.decided_at()), safe_within_ms(Cause::command_not_sendable));
  rig.run_for(milliseconds(10));
  EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
  EXPECT_EQ(rig.monitor().violations(), 0u);
}

/// The controller has reset its nodes by then. Their silence must not become the cause.
TEST(InterfaceDownFault, IsDecidedEvenIfTheInterfaceIsSoonUpAgain) {
  shows("S-011");
  FaultRig rig(one_axis());
  rig.start();
  ASSERT_TRUE(rig.tracks());
  rig.run_for(milliseconds(400));
  rig.begin(Trouble::interface_down);
  rig.end(Trouble::interface_down);
  ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(2)));
  EXPECT_EQ(rig.axis().fault().cause, Cause::interface_down);
}

/// The foreign heartbeat arrives just after a step, and the sample of the next step is lost.
TEST(AnotherControllerFault, SendsTheSafeCommandEvenIfTheNextSampleIsLost) {
  shows("S-044");
  FaultRig rig(one_axis());
  rig.start();
  ASSERT_TRUE(rig.tracks());
  rig.run_for(std::chrono::microseconds(400'300) - rig.clock().now().time_since_epoch() % milliseconds(1));
  rig.begin(Trouble::foreign_heartbeat);
  rig.begin(Trouble::sample_lost);
  rig.run_for(milliseconds(3));
  ASSERT_EQ(rig.axis().fault().cause, Cause::another_controller);
  const double safe_ms = ms(rig.monitor().safe_since() - rig.decided_at());
  EXPECT_GT(safe_ms, 1.5) << "not the step of the next sample";
  EXPECT_LE(safe_ms, safe_between_steps_ms);
}

TEST(FollowingErrorFault, DoesNotOccurWithinTheLag) {
  shows("S-034");
  for (const bool allowed : {true, false}) {
    config::Config config = one_axis();
    controller::AxisConfig& axis = config.axes[0].control;
    axis.law.structure = controller::Structure::pi;  // lags by more than 4 um at 126 um/s
    axis.law.pi = {.kp = 0.0, .ki_per_s = 20.0};
    axis.following_error.lag = milliseconds(allowed ? 60 : 0);
    FaultRig rig(config);
    rig.start();
    ASSERT_TRUE(rig.tracks());
    const bool lost = rig.reaches(AxisState::faulted, std::chrono::seconds(2));
    EXPECT_EQ(lost, !allowed);
    EXPECT_EQ(rig.axis().fault().cause, allowed ? Cause::none : Cause::following_error);
  }
}

/// Enable follows clear in the next cycle, so the last status does not contain the present output of the
/// amplifier.
TEST(Rearming, StartsFromThePresentOutputOfTheAmplifier) {
  shows("S-054");
  FaultRig rig(one_axis());
  rig.start();
  ASSERT_TRUE(rig.tracks());
  for (int i = 0; i < 40; ++i) {
    rig.run_for(milliseconds(400 + i));
    rig.begin(Trouble::sample_bad);
    ASSERT_TRUE(rig.reaches(AxisState::faulted, milliseconds(3)));
    rig.end(Trouble::sample_bad);
    rig.run_for(milliseconds(i % 12));
    ASSERT_EQ(rig.ask(Kind::clear), "");
    ASSERT_EQ(rig.ask(Kind::enable), "");
    ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  }
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
}

}  // namespace
}  // namespace hystcan::support::fault_test
