// The faults of an axis: each causes the safe command in the deciding cycle, and the axis stays faulted until
// it is cleared.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>

#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_fault_test {
namespace {

struct FaultCase {
  const char* name;
  Cause cause;
  std::function<void(AxisInput&)> disturb;
  int cycles;  ///< until the axis is faulted

  friend void PrintTo(const FaultCase& fault, std::ostream* out) { *out << fault.name; }
};

void expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage stage, const FaultCase& fault) {
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle();
  for (int i = 1; i < fault.cycles; ++i) {
    EXPECT_TRUE(stage.cycle(fault.disturb).enable) << "cycle " << i << " is still bridged";
  }
  const AxisCommand deciding = stage.cycle(fault.disturb);
  EXPECT_FALSE(deciding.enable);
  EXPECT_EQ(deciding.drive, 0.0);
  EXPECT_EQ(stage.axis.state(), AxisState::faulted);
  EXPECT_EQ(stage.axis.fault().cause, fault.cause);
  EXPECT_DOUBLE_EQ(stage.axis.fault().time_s, stage.time_s);
  EXPECT_FALSE(remedy(fault.cause).empty());

  for (int i = 0; i < 100; ++i)
    EXPECT_FALSE(stage.cycle().enable) << "the cause is gone, but the fault is latched";
  EXPECT_EQ(stage.axis.fault().cause, fault.cause);
}

class EveryFault : public testing::TestWithParam<FaultCase> {};

TEST_P(EveryFault, LeadsToTheSafeCommandInTheDecidingCycleAndLatches) {
  expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage(), GetParam());
}

TEST_P(EveryFault, LeadsToTheSafeCommandInOpenLoopTooExceptTheFollowingError) {
  AxisConfig config = support::excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0});
  if (GetParam().cause != Cause::following_error)
    return expect_the_safe_command_in_the_deciding_cycle_and_ever_after(IdealStage(config), GetParam());
  config.supervision.position_jump_um = 0.0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 100; ++i) stage.cycle(GetParam().disturb);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << "there is no reference to lose";
}

INSTANTIATE_TEST_SUITE_P(
    Axis, EveryFault,
    testing::Values(
        FaultCase{"SampleMissing", Cause::sample_missing, [](AxisInput& in) { in.position_um.reset(); }, 4},
        FaultCase{"SensorStatus", Cause::sensor_status, [](AxisInput& in) { in.sensor_status_good = false; },
                  1},
        FaultCase{"PositionOutOfRange", Cause::position_implausible,
                  [](AxisInput& in) { in.position_um = 40.0; }, 1},
        FaultCase{"PositionNotANumber", Cause::position_implausible,
                  [](AxisInput& in) { in.position_um = std::numeric_limits<double>::quiet_NaN(); }, 1},
        FaultCase{"SensorSilent", Cause::sensor_silent, [](AxisInput& in) { in.health.sensor_alive = false; },
                  1},
        FaultCase{"AmplifierSilent", Cause::amplifier_silent,
                  [](AxisInput& in) { in.health.amplifier_alive = false; }, 1},
        FaultCase{"SampleLate", Cause::sample_late,
                  [](AxisInput& in) {
                    in.position_um.reset();
                    in.late_sample = true;
                  },
                  4},
        FaultCase{"SensorStopped", Cause::node_not_operational,
                  [](AxisInput& in) { in.health.sensor_operational = false; }, 1},
        FaultCase{"AmplifierStopped", Cause::node_not_operational,
                  [](AxisInput& in) { in.health.amplifier_operational = false; }, 1},
        FaultCase{"Emergency", Cause::node_emergency, [](AxisInput& in) { in.health.emergency = true; }, 1},
        FaultCase{"PositionJumped", Cause::position_jumped, [](AxisInput& in) { *in.position_um += 13.0; },
                  4},
        FaultCase{"BusPassive", Cause::bus_passive, [](AxisInput& in) { in.health.bus_passive = true; }, 10},
        FaultCase{"NodeRestarted", Cause::node_restarted, [](AxisInput& in) { in.health.restarted = true; },
                  1},
        FaultCase{"AmplifierFault", Cause::amplifier_fault,
                  [](AxisInput& in) { in.health.amplifier_fault = true; }, 1},
        FaultCase{"InterfaceDown", Cause::interface_down,
                  [](AxisInput& in) { in.health.interface_up = false; }, 1},
        FaultCase{"BusOff", Cause::bus_off, [](AxisInput& in) { in.health.bus_on = false; }, 1},
        FaultCase{"CycleOverrun", Cause::cycle_overrun, [](AxisInput& in) { in.dt_s = 0.011; }, 1},
        FaultCase{"FollowingError", Cause::following_error,
                  [](AxisInput& in) { in.position_um = 12.2 + 1e-3 * in.time_s; }, 3}),
    [](const auto& test) { return test.param.name; });

TEST(AxisFault, IsTheCauseIfTheAmplifierNeverBecomesEnabled) {
  IdealStage stage;
  stage.axis.start(false);
  for (int i = 0; i < 1000; ++i) stage.cycle([](AxisInput& in) { in.health.amplifier_enabled = false; });
  EXPECT_EQ(stage.axis.fault().cause, Cause::amplifier_not_enabled);
}

TEST(AxisFault, KeepsItsFirstCauseAndTime) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  stage.axis.trip(Cause::another_controller, 1.5);
  stage.axis.trip(Cause::interface_down, 2.5);
  EXPECT_EQ(stage.axis.fault().cause, Cause::another_controller);
  EXPECT_EQ(stage.axis.fault().time_s, 1.5);
}

TEST(AxisFault, RemainsSafeAtAStop) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  ASSERT_EQ(stage.axis.state(), AxisState::faulted);
  stage.axis.stop();
  for (int i = 0; i < 100; ++i) {
    const AxisCommand command = stage.cycle();
    EXPECT_FALSE(command.enable);
    EXPECT_EQ(command.drive, 0.0);
    EXPECT_EQ(stage.axis.state(), AxisState::faulted);
  }
  EXPECT_EQ(stage.axis.fault().cause, Cause::sensor_status);
}

TEST(AxisFault, IsSafeAtOnceDuringTheRampOfAStop) {
  IdealStage stage;
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  stage.axis.stop();
  stage.cycle();
  ASSERT_GT(stage.command.drive, 10.0);
  const AxisCommand command = stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  EXPECT_FALSE(command.enable);
  EXPECT_EQ(command.drive, 0.0);
  EXPECT_EQ(stage.axis.state(), AxisState::faulted);
}

/// In open loop the drive rises by 10 V/s while the position does not change. The gate is symmetrical.
TEST(AxisFault, ComparesAFrozenPositionWithTheWholeDriveRange) {
  AxisConfig config = support::excited_piezo(
      Excitation::Hysteresis{.low = 0.0, .high = 90.0, .slew_per_s = 10.0, .rest_s = 0.0});
  config.gate.drive_min = -100.0;
  config.supervision.frozen_cycles = 50;
  config.supervision.position_jump_um = 0.0;
  IdealStage stage(config);
  ASSERT_TRUE(stage.tracks());
  const auto frozen = [](AxisInput& in) { in.position_um = 5.0; };
  for (int i = 0; i < 390; ++i) stage.cycle(frozen);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << "3.9 V";
  for (int i = 0; i < 20; ++i) stage.cycle(frozen);
  EXPECT_EQ(stage.axis.fault().cause, Cause::position_frozen) << "4.1 V of 200 V";
}

TEST(AxisClear, IsRefusedUnlessTheAxisIsFaultedAndLeadsToOffline) {
  IdealStage stage;
  EXPECT_EQ(stage.axis.clear(), Refusal::no_fault_to_clear);
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.axis.clear(), Refusal::no_fault_to_clear);
  stage.cycle([](AxisInput& in) { in.sensor_status_good = false; });
  ASSERT_EQ(stage.axis.state(), AxisState::faulted);
  EXPECT_EQ(stage.axis.clear(), std::nullopt);
  EXPECT_EQ(stage.axis.clear(), Refusal::no_fault_to_clear) << "a clear is never queued";
  EXPECT_EQ(stage.axis.state(), AxisState::offline);
  EXPECT_EQ(stage.axis.fault().cause, Cause::none);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(stage.cycle().enable) << "a clear does not start the axis";
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 500; ++i) stage.cycle();
  EXPECT_NEAR(stage.axis.report().position_um, 15.0, 1e-9) << "its memory is wiped out again";
}

}  // namespace
}  // namespace hystcan::controller::axis_fault_test
