// A sensor that is reversed or scaled wrongly, or an amplifier that saturates below its range without
// reporting it: the ramp of the start-up moves the position differently from the model, and the axis faults
// before it has moved far.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "model/hysteresis_parameters.h"
#include "tests/controller/control/ideal_stage.h"
#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::ramp_check_test {
namespace {

using controller::AxisConfig;
using controller::AxisInput;
using controller::AxisState;
using controller::Cause;
using controller::IdealStage;

/// A wipe of five ranges per second, as `hystcan init` proposes.
AxisConfig slowly_wiped() {
  AxisConfig config = piezo_axis();
  config.wipe_slew_per_s = 500.0;
  config.wipe_dwell_s = 0.1;
  config.supervision.position_min_um = -40.0;
  return config;
}

/// Returns the highest drive of a start-up that ends with the fault; 0 if there is no fault.
double highest_drive(const AxisConfig& config, const std::function<double(double)>& shown_um) {
  IdealStage stage(config);
  stage.axis.start(false);
  for (int i = 0; i < 2000 && stage.axis.state() != AxisState::tracking; ++i)
    stage.cycle([&](AxisInput& in) {
      in.health.amplifier_ready = i > 20;  // a status needs some time
      in.position_um = shown_um(*in.position_um);
    });
  EXPECT_TRUE(stage.axis.state() == AxisState::tracking || stage.axis.state() == AxisState::faulted);
  return stage.axis.fault().cause == Cause::position_contradicts ? stage.highest_drive : 0.0;
}

void expect_within(double drive, const AxisConfig& config, const std::function<double(double)>& shown_um) {
  const double highest = highest_drive(config, shown_um);
  std::printf("found at %.1f V of 100 V, allowed %.0f V\n", highest, drive);
  EXPECT_GT(highest, 0.0);
  EXPECT_LE(highest, drive);
}

TEST(PositionContradictsDrive, DetectsAReversedSensorWithinFivePercentOfTheRange) {
  shows("S-033");
  expect_within(5.0, slowly_wiped(), [](double um) { return -um; });
  expect_within(5.0, slowly_wiped(), [](double um) { return 30.8 - um; });
}

TEST(PositionContradictsDrive, DetectsALowGainWithinAQuarterOfTheRange) {
  shows("S-033");
  expect_within(25.0, slowly_wiped(), [](double um) { return 0.5 * um; });
  expect_within(25.0, slowly_wiped(), [](double um) { return 0.1 * um; });
  int cycle = 0;
  expect_within(25.0, slowly_wiped(), [&](double) { return 1e-4 * (++cycle % 2); });
}

// 2 V per cycle: the delays correspond to more than a quarter of the range.
TEST(PositionContradictsDrive, DetectsAWrongSensorWithin25CyclesOfAFastRamp) {
  AxisConfig config = slowly_wiped();
  config.wipe_slew_per_s = 2000.0;
  expect_within(12.0, config, [](double um) { return -um; });
  expect_within(50.0, config, [](double um) { return 0.5 * um; });
  expect_within(50.0, config, [](double um) { return 0.1 * um; });
}

// 13.35 um is the position at half of the range, and 25 V more are 75 V; 19.7 um is the position at 70 V.
TEST(PositionContradictsDrive, DetectsAnEndStopWithinAQuarterOfTheRange) {
  expect_within(75.0, slowly_wiped(), [](double um) { return std::min(um, 13.35); });
  expect_within(95.0, slowly_wiped(), [](double um) { return std::min(um, 19.7); });
}

// A delay of ten milliseconds that is not configured, in a ramp of five ranges per second.
TEST(PositionContradictsDrive, AcceptsSensorWithUnstatedDelay) {
  shows("S-009");
  std::deque<double> under_way(10, 0.0);
  EXPECT_EQ(highest_drive(slowly_wiped(),
                          [&](double um) {
                            under_way.push_back(um);
                            under_way.pop_front();
                            return under_way.front();
                          }),
            0.0);
}

// The drive moves by up to half a range before the sample shows it, and as much after each turn, where the
// ramp does not wait.
TEST(PositionContradictsDrive, AcceptsSensorWithStatedDelay) {
  shows("S-009");
  for (const int delay_ms : {1, 3, 10, 30, 100})
    for (const double dwell_s : {0.0, 0.1}) {
      AxisConfig config = slowly_wiped();
      config.law.structure = controller::Structure::inverse;
      config.following_error.error_um = 100.0;
      config.wipe_dwell_s = dwell_s;
      config.delays.sensor_delay = std::chrono::milliseconds(delay_ms);
      std::deque<double> under_way(static_cast<std::size_t>(delay_ms), 0.0);
      EXPECT_EQ(highest_drive(config,
                              [&](double um) {
                                under_way.push_back(um);
                                const double shown_um = under_way.front();
                                under_way.pop_front();
                                return shown_um;
                              }),
                0.0)
          << delay_ms << " ms, waits for " << dwell_s << " s";
    }
}

TEST(PositionContradictsDrive, IsDetectedAtALaterStart) {
  IdealStage stage(slowly_wiped());
  ASSERT_TRUE(stage.tracks());
  for (int i = 0; i < 300; ++i) stage.cycle();
  stage.axis.stop();
  ASSERT_TRUE(stage.reaches(AxisState::offline));
  stage.highest_drive = 0.0;
  stage.axis.start(false);
  for (int i = 0; i < 500 && stage.axis.state() != AxisState::faulted; ++i)
    stage.cycle([](AxisInput& in) { in.position_um = 30.8 - *in.position_um; });
  EXPECT_EQ(to_string(stage.axis.fault().cause), "position contradicts drive");
  EXPECT_LE(stage.highest_drive, 5.0);
}

// The load discharges from 40 V until the relay closes; the position falls during or before this time.
TEST(PositionContradictsDrive, AcceptsStageThatFallsBeforeItIsEnabled) {
  for (const double um_per_volt : {0.3, 0.0}) {
    IdealStage stage(slowly_wiped());
    stage.axis.start(false);
    double output = 40.0;
    for (int i = 0; i < 2000 && stage.axis.state() != AxisState::tracking; ++i)
      stage.cycle([&](AxisInput& in) {
        if (i >= 400) return;
        if (i > 5) output *= 0.98;
        in.health.amplifier_enabled = false;
        in.health.amplifier_output = output;
        in.position_um = um_per_volt * output + 1e-4 * (i % 2);
      });
    EXPECT_EQ(stage.axis.state(), AxisState::tracking) << to_string(stage.axis.fault().cause);
  }
}

// The trial of the watchdog ramps from 20 V to the safe drive. Then the output falls to 0 V, where the next
// ramp begins.
TEST(PositionContradictsDrive, AcceptsRampAfterWatchdogVerification) {
  AxisConfig config = slowly_wiped();
  config.verify_watchdog = true;
  config.gate.safe_drive = 60.0;
  IdealStage stage(config);
  double output = 20.0;
  int waits = 0;
  stage.axis.start(false);
  for (int i = 0; i < 8000 && stage.axis.state() != AxisState::tracking; ++i)
    stage.cycle([&](AxisInput& in) {
      const bool trips = stage.command.withheld;
      if (trips) waits = 4000;
      output = waits > 0 ? 0.0 : stage.command.enable ? stage.command.drive : output;
      in.health.amplifier_fault = trips;
      in.health.amplifier_ready = waits == 0;
      in.health.amplifier_enabled = stage.command.enable && waits == 0;
      in.health.amplifier_output = output;
      in.position_um = 0.3 * output;
      waits = std::max(0, waits - 1);
    });
  EXPECT_EQ(stage.axis.state(), AxisState::tracking) << to_string(stage.axis.fault().cause);
}

// A straight line predicts the direction and the order of magnitude: enough to detect a reversed or a stuck
// sensor.
TEST(PositionContradictsDrive, IsDetectedWithALinearModel) {
  AxisConfig config = slowly_wiped();
  config.law.model = model::straight_line("V", "um", {0.0, 100.0}, {0.0, 30.0});
  const auto shown = [&](double share) { return [share](double um) { return share * um; }; };
  expect_within(5.0, config, shown(-1.0));
  expect_within(25.0, config, shown(0.02));
  EXPECT_EQ(highest_drive(config, shown(0.4)), 0.0);
  EXPECT_EQ(highest_drive(config, shown(2.0)), 0.0);
}

/// Draws an honest stage that differs from its configuration: slope up to 20 % off, mode up to 20 % off,
/// damping up to twofold, sensor up to 10 ms later, noisy.
config::Config drawn(std::mt19937_64& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  config::Config config = one_axis();
  controller::AxisConfig& control = config.axes[0].control;
  twin::AxisConfig& stage = config.axes[0].twin;
  control.law.structure = controller::Structure::inverse;
  control.following_error.error_um = 100.0;
  control.supervision.position_min_um = -100.0;
  control.supervision.position_max_um = 100.0;
  control.supervision.position_jump_um = 0.0;
  control.delays.resonance_Hz = std::exp(between(std::log(25.0), std::log(1000.0)));
  control.wipe_slew_per_s = between(50.0, 500.0);
  control.wipe_dwell_s = 0.1;
  stage.plant.mode.natural_frequency_Hz = control.delays.resonance_Hz * between(0.8, 1.2);
  stage.plant.mode.damping_ratio = std::exp(between(std::log(0.01), std::log(0.3)));
  control.delays.damping_ratio = stage.plant.mode.damping_ratio * std::exp2(between(-1.0, 1.0));
  stage.sensor.delay = can::Duration(std::llround(1e9 * between(0.0, 0.01)));
  stage.sensor.noise_um_rms = between(0.0, 0.1);
  stage.sensor.gain_error_percent = between(-20.0, 20.0);
  stage.plant.amplifier.bandwidth_Hz = std::exp(between(std::log(50.0), std::log(2000.0)));
  control.delays.amplifier_bandwidth_Hz = stage.plant.amplifier.bandwidth_Hz * between(0.8, 1.2);
  return config;
}

// The second start begins while the stage rings, immediately after a fault has let it fall.
TEST(StartUp, AcceptsAHundredInaccuratelyConfiguredStages) {
  shows("S-009");
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    FaultRig rig(drawn(random));
    rig.start();
    ASSERT_TRUE(rig.tracks(std::chrono::seconds(15))) << seed << ": " << to_string(rig.axis().fault().cause);
    rig.run_for(std::chrono::milliseconds(400));
    twin::FaultSpec bad = twin::fault_spec(twin::Fault::sensor_bad_status, "x");
    bad.lasts = std::chrono::milliseconds(2);
    rig.stage_faults().inject(bad);
    ASSERT_TRUE(rig.reaches(AxisState::faulted, std::chrono::milliseconds(100))) << seed;
    rig.run_for(std::chrono::milliseconds(5));
    ASSERT_EQ(rig.ask(controller::Request::Kind::clear), "");
    ASSERT_EQ(rig.ask(controller::Request::Kind::enable), "");
    ASSERT_TRUE(rig.tracks(std::chrono::seconds(15)))
        << seed << ", again: " << to_string(rig.axis().fault().cause);
  }
}

TEST(StartUp, DetectsAReversedSensorWithinAnEighthOfTheRange) {
  double furthest = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    std::mt19937_64 random(seed);
    config::Config config = drawn(random);
    config.twin.faults = {twin::fault_spec(twin::Fault::sensor_gain, "x")};
    FaultRig rig(config);
    rig.start();
    while (rig.axis().state() != AxisState::faulted && rig.axis().state() != AxisState::tracking) {
      rig.run_for(std::chrono::milliseconds(1));
      furthest = std::max(furthest, rig.axis().report().drive);
    }
    ASSERT_EQ(to_string(rig.axis().fault().cause), "position contradicts drive") << seed;
  }
  std::printf("reversed: at most %.1f %% of the range\n", furthest);
  EXPECT_LE(furthest, 12.5);
}

/// Returns the cause of a fault of the twin that lasts from its start over the whole start-up on the
/// simulated bus.
Cause cause_of(twin::Fault kind, double value) {
  config::Config config = one_axis();
  config.axes[0].control.wipe_slew_per_s = 500.0;
  config.axes[0].control.supervision.position_min_um = -40.0;
  twin::FaultSpec spec = twin::fault_spec(kind, "x");
  spec.value = value;
  config.twin.faults = {spec};
  FaultRig rig(config);
  rig.start();
  rig.tracks();
  EXPECT_EQ(rig.monitor().violations(), 0u) << rig.monitor().found().front();
  return rig.axis().fault().cause;
}

TEST(StartUp, FaultsIfTheSensorOrAmplifierIsWrong) {
  shows("S-072");
  using twin::Fault;
  EXPECT_EQ(cause_of(Fault::sensor_gain, -1.0), Cause::position_contradicts) << "reversed";
  EXPECT_EQ(cause_of(Fault::sensor_gain, 0.1), Cause::position_contradicts);
  EXPECT_EQ(cause_of(Fault::sensor_gain, 0.5), Cause::position_contradicts);
  EXPECT_EQ(cause_of(Fault::limited_output, 0.0), Cause::output_differs) << "an interlock is open";
  const Cause at_its_limit = cause_of(Fault::limited_output, 50.0);
  EXPECT_TRUE(at_its_limit == Cause::output_differs || at_its_limit == Cause::position_contradicts);
  EXPECT_EQ(cause_of(Fault::sensor_offset, 2.0), Cause::none) << "where the stage stands is not known";
}

}  // namespace
}  // namespace hystcan::support::ramp_check_test
