// Gains above the critical ones: the fault reports that the loop oscillates. With faster growth another limit
// may trip first, `position jumped` or `position implausible`.
#include <gtest/gtest.h>

#include "config/schema/config.h"
#include "controller/analysis/linear_loop.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::unstable_loop_test {
namespace {

using controller::AxisState;
using controller::Cause;

constexpr const char* stages[]{"piezo.toml", "soft_stage.toml"};

/// Returns the largest ki for which the linear loop is stable.
double critical_ki_per_s(const char* stage) {
  const rehearsal::Setup setup = support::shipped(stage);
  const controller::AxisConfig& axis = setup.controller.axes[0].axis;
  const controller::LinearLoop loop(
      controller::loop_config_of(axis.law, axis.delays, 1.0 / setup.controller.rate_Hz));
  return controller::largest_stable_gains(loop, axis.law.pi).ki_per_s;
}

Cause cause_with(const char* stage, double controller::PiGains::*gain, double value) {
  // set here, because a configuration with such gains is refused
  rehearsal::Setup setup = support::shipped(stage);
  setup.controller.axes.resize(1);
  setup.controller.axes[0].axis.law.pi.*gain = value;
  setup.twin.axes.resize(1);
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.start();
  loop.run_for(std::chrono::seconds(15));
  return loop.controller().axis(0).fault().cause;
}

TEST(UnstableLoop, IsTheCauseAboveTheCriticalGain) {
  shows("S-035");
  for (const char* stage : stages)
    for (const double factor : {1.15, 1.3})
      EXPECT_EQ(
          to_string(cause_with(stage, &controller::PiGains::ki_per_s, factor * critical_ki_per_s(stage))),
          "loop unstable")
          << stage << ", " << factor;
}

TEST(UnstableLoop, DoesNotOccurBelowTheCriticalGain) {
  shows("S-007");
  for (const char* stage : stages)
    for (const double factor : {0.2, 0.5, 0.8})
      EXPECT_EQ(
          to_string(cause_with(stage, &controller::PiGains::ki_per_s, factor * critical_ki_per_s(stage))),
          "none")
          << stage << ", " << factor;
}

TEST(UnstableLoop, IsTheCauseIfTheProportionalGainIsTooHigh) {
  for (const double kp : {1.2})
    EXPECT_EQ(to_string(cause_with(stages[0], &controller::PiGains::kp, kp)), "loop unstable") << kp;
}

Cause cause_with_sensor_delay(double ki_per_s, std::chrono::microseconds delay) {
  rehearsal::Setup setup = support::shipped("piezo.toml");
  setup.controller.axes.resize(1);
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.law.pi.ki_per_s = ki_per_s;
  // slow, because with an unstated delay a faster ramp is far ahead of the sensor
  axis.wipe_slew_per_s = 50.0;
  axis.setpoint = {{.shape = controller::Hold{.level_um = 15.0, .duration_s = 10.0}}};
  setup.twin.axes.resize(1);
  setup.twin.axes[0].axis.sensor.delay = delay;
  // with_structure() also disables the limit of the following error
  setup = with_structure(setup, controller::Structure::inverse_pi);
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.start();
  loop.run_for(std::chrono::seconds(10));
  return loop.controller().axis(0).fault().cause;
}

// 0.5 to 31 um at 16 Hz: the drive is at its limits for half of the time, and the mode rings.
TEST(UnstableLoop, IsTheCauseOfASlowOscillationFromLimitToLimit) {
  EXPECT_EQ(to_string(cause_with_sensor_delay(150.0, std::chrono::milliseconds(20))), "loop unstable");
  EXPECT_EQ(to_string(cause_with_sensor_delay(100.0, std::chrono::milliseconds(40))), "loop unstable");
}

// The oscillation doubles in eight periods.
TEST(UnstableLoop, IsTheCauseOfASlowlyGrowingOscillation) {
  for (const int delay_us : {600, 620, 640})
    EXPECT_EQ(to_string(cause_with_sensor_delay(409.0, std::chrono::microseconds(delay_us))), "loop unstable")
        << delay_us;
}

// A triangle whose seventh harmonic excites the mode. With ki 0.1 the loop gain at the mode is 0.002.
TEST(UnstableLoop, DoesNotOccurIfTheReferenceExcitesTheMode) {
  shows("S-007");
  rehearsal::Setup setup = support::shipped("soft_stage.toml");
  controller::AxisConfig& axis = setup.controller.axes[0].axis;
  axis.law.notch.reset();
  axis.law.pi = {.ki_per_s = 0.1};
  axis.delays.second_order = false;
  axis.setpoint = {{.shape = controller::Triangle{
                        .low_um = 30.0, .high_um = 70.0, .frequency_Hz = 220.0 / 7.0, .cycles = 100.0}}};
  setup = with_structure(setup, controller::Structure::inverse_pi);
  rehearsal::Rehearsal loop(setup, support::ignore);
  loop.start();
  loop.run_for(std::chrono::seconds(6));
  EXPECT_EQ(to_string(loop.controller().axis(0).fault().cause), "none");
}

struct SteppedStage {
  double resonance_Hz, damping_ratio, ki_per_s;
  bool interpolated;
};

// Gain margins of 12 to 20 dB: each step excites the mode, and the ringing decays.
TEST(UnstableLoop, DoesNotOccurIfStepsExciteALightlyDampedMode) {
  shows("S-007");
  for (const SteppedStage& of :
       {SteppedStage{90.0, 0.02, 8.0, true}, SteppedStage{220.0, 0.05, 95.9, true},
        SteppedStage{220.0, 0.02, 22.9, false}, SteppedStage{400.0, 0.02, 60.0, false}})
    for (const double height_um : {3.0, 3.5}) {
      rehearsal::Setup setup = support::shipped("piezo.toml");
      setup.controller.axes.resize(1);
      setup.twin.axes.resize(1);
      controller::AxisConfig& axis = setup.controller.axes[0].axis;
      axis.law.pi = {.ki_per_s = of.ki_per_s};
      axis.delays.resonance_Hz = of.resonance_Hz;
      axis.delays.damping_ratio = of.damping_ratio;
      axis.delays.interpolated = of.interpolated;
      axis.setpoint = {
          {.shape = controller::Step{.from_um = 8.0, .to_um = 8.0 + height_um, .dwell_s = 0.3, .steps = 6}}};
      setup.twin.axes[0].axis.plant.mode = {of.resonance_Hz, of.damping_ratio};
      setup.twin.axes[0].axis.interpolate = of.interpolated;
      rehearsal::Rehearsal loop(setup, support::ignore);
      loop.start();
      loop.run_for(std::chrono::seconds(4));
      EXPECT_NE(to_string(loop.controller().axis(0).fault().cause), "loop unstable")
          << of.resonance_Hz << " Hz, damping " << of.damping_ratio << ", " << height_um << " um";
    }
}

}  // namespace
}  // namespace hystcan::unstable_loop_test
