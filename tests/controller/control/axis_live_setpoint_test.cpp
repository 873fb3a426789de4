// Live setpoints: the accepted positions and times, and a reference without jumps. Then the restored memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "controller/analysis/feed_forward_design.h"
#include "tests/controller/control/ideal_stage.h"
#include "tests/support/piezo.h"

namespace hystcan::controller::axis_live_setpoint_test {
namespace {

/// The model reaches 1.5 um at 0 V from above, and 30 um at 100 V.
IdealStage tracking_stage(const AxisConfig& config = support::piezo_axis()) {
  IdealStage stage(config);
  EXPECT_TRUE(stage.tracks());
  for (int i = 0; i < 200; ++i) stage.cycle();
  return stage;
}

TEST(AxisLiveSetpoint, MustBeWithinTheRangeOfTheModel) {
  const model::HysteresisParameters model = support::piezo_model();
  const double lowest_um = model.descending.value(0.0);
  const double highest_um = model.ascending.value(100.0);
  IdealStage stage = tracking_stage();
  EXPECT_EQ(stage.axis.go_to(lowest_um), std::nullopt);
  EXPECT_EQ(stage.axis.go_to(highest_um), std::nullopt);
  EXPECT_EQ(stage.axis.go_to(lowest_um - 1e-9), Refusal::position_out_of_range);
  EXPECT_EQ(stage.axis.go_to(highest_um + 1e-9), Refusal::position_out_of_range);
  EXPECT_EQ(stage.axis.go_to(std::numeric_limits<double>::quiet_NaN()), Refusal::position_out_of_range);
}

TEST(AxisLiveSetpoint, MustBeAPlausiblePosition) {
  AxisConfig config = support::piezo_axis();
  config.supervision.position_min_um = 1.75;
  config.supervision.position_max_um = 29.0;
  config.setpoint = {{.shape = Hold{.level_um = 15.0, .duration_s = 1.0}, .transition_s = 0.05}};
  AxisTuning tuning(config, false);
  IdealStage stage = tracking_stage();
  ASSERT_EQ(stage.axis.retune(tuning), std::nullopt);
  EXPECT_EQ(stage.axis.go_to(1.75), std::nullopt);
  EXPECT_EQ(stage.axis.go_to(29.0), std::nullopt);
  EXPECT_EQ(stage.axis.go_to(1.74), Refusal::position_out_of_range);
  EXPECT_EQ(stage.axis.go_to(29.01), Refusal::position_out_of_range);
}

TEST(AxisLiveSetpoint, IsRefusedIfTheAxisDoesNotTrack) {
  IdealStage stage;
  EXPECT_EQ(stage.axis.go_to(15.0), Refusal::not_tracking);
  EXPECT_EQ(stage.axis.resume(), Refusal::not_tracking);
  ASSERT_TRUE(stage.tracks());
  stage.cycle();
  EXPECT_EQ(stage.axis.go_to(15.0), std::nullopt);
  EXPECT_EQ(stage.axis.resume(), std::nullopt);
  stage.axis.stop();
  EXPECT_EQ(stage.axis.go_to(15.0), Refusal::not_tracking) << "it is about to ramp down";
  EXPECT_EQ(stage.axis.resume(), Refusal::not_tracking);
}

TEST(AxisLiveSetpoint, IsRefusedInOpenLoop) {
  IdealStage stage(support::excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0}));
  ASSERT_TRUE(stage.tracks());
  EXPECT_EQ(stage.axis.go_to(15.0), Refusal::not_tracking);
  EXPECT_EQ(stage.axis.resume(), Refusal::not_tracking);
}

/// Returns the largest change of the reference from cycle to cycle.
double largest_step_um(IdealStage& stage, int cycles) {
  double largest_um = 0.0;
  for (int i = 0; i < cycles; ++i) {
    const double before_um = stage.axis.report().reference_um;
    stage.cycle();
    largest_um = std::max(largest_um, std::abs(stage.axis.report().reference_um - before_um));
  }
  return largest_um;
}

AxisConfig limited() {
  AxisConfig config = support::piezo_axis();
  config.transition_limits = {.slew_um_per_s = 100.0, .acceleration_um_per_s2 = 10'000.0};
  return config;
}

TEST(AxisLiveSetpoint, IsReachedFromThePresentReferenceWithinTheLimits) {
  IdealStage stage = tracking_stage(limited());
  ASSERT_EQ(stage.axis.go_to(20.0), std::nullopt);
  EXPECT_LE(largest_step_um(stage, 120), 100.0 * cycle_s * (1 + 1e-9));
  EXPECT_EQ(stage.axis.report().reference_um, 20.0);
}

/// Returns the drives of some cycles while the axis follows a triangle. A live setpoint arrives in the first
/// cycle, between its SYNC and its sample or after its sample.
std::vector<double> drives_with_a_live_setpoint(bool plant_inverse, bool before_the_sample) {
  AxisConfig config = limited();
  config.setpoint = {{.shape = Triangle{.low_um = 10.0, .high_um = 20.0, .frequency_Hz = 5.0, .cycles = 10.0},
                      .transition_s = 0.05}};
  config.delays.plant_inverse = plant_inverse;
  plan_feed_forward(config, 1.0 / cycle_s);
  IdealStage stage = tracking_stage(config);
  stage.axis.prepare(stage.next_input().reference_time_s(), cycle_s);
  std::optional<Refusal> refusal;
  if (before_the_sample) refusal = stage.axis.go_to(18.0);
  std::vector<double> drives{stage.cycle().drive};
  if (!before_the_sample) refusal = stage.axis.go_to(18.0);
  EXPECT_EQ(refusal, std::nullopt);
  for (int i = 0; i < 100; ++i) drives.push_back(stage.cycle().drive);
  EXPECT_EQ(stage.axis.state(), AxisState::tracking);
  return drives;
}

TEST(AxisLiveSetpoint, BeforeTheSampleOfACycleActsAsOneAfterIt) {
  for (const bool plant_inverse : {false, true})
    EXPECT_EQ(drives_with_a_live_setpoint(plant_inverse, true),
              drives_with_a_live_setpoint(plant_inverse, false));
}

TEST(AxisLiveSetpoint, IsLeftForTheConfiguredReferenceWithinTheLimits) {
  IdealStage stage = tracking_stage(limited());
  ASSERT_EQ(stage.axis.go_to(20.0), std::nullopt);
  for (int i = 0; i < 200; ++i) stage.cycle();
  ASSERT_EQ(stage.axis.resume(), std::nullopt);
  EXPECT_LE(largest_step_um(stage, 120), 100.0 * cycle_s * (1 + 1e-9));
  EXPECT_EQ(stage.axis.report().reference_um, 15.0);
}

// ---- a restored memory

/// An axis that was never driven, with a restored memory.
Axis restored(MemorySource start_up) {
  AxisConfig config = support::piezo_axis();
  config.start_up = start_up;
  Axis axis(config);
  axis.restore(model::Hysteresis(config.law.model).at_lower_threshold());
  return axis;
}

TEST(AxisMemory, IsKnownAtOnceIfAssumedOrRestored) {
  EXPECT_EQ(restored(MemorySource::wipe).law_to_save(), nullptr);
  EXPECT_NE(restored(MemorySource::assume).law_to_save(), nullptr);
  EXPECT_NE(restored(MemorySource::restore).law_to_save(), nullptr);
}

TEST(AxisMemory, IsNeitherRestoredNorSavedInOpenLoop) {
  AxisConfig config = support::excited_piezo(Excitation::Hysteresis{.low = 10.0, .high = 90.0});
  config.start_up = MemorySource::assume;
  Axis axis(config);
  axis.restore(model::Hysteresis(config.law.model).at_lower_threshold());
  EXPECT_EQ(axis.closed_loop(), nullptr);
  EXPECT_EQ(axis.law_to_save(), nullptr);
}

}  // namespace
}  // namespace hystcan::controller::axis_live_setpoint_test
