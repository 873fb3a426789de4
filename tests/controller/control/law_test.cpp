#include "controller/control/law.h"

#include <gtest/gtest.h>

#include "model/hysteresis_parameters.h"
#include "tests/support/piezo.h"
#include "tests/support/wiped.h"

namespace hystcan::controller::law_test {
namespace {

constexpr double dt_s = 1e-3;

ControlLaw law(Structure structure, PiGains pi = {.kp = 0.0, .ki_per_s = 100.0}) {
  ControlLaw result({.structure = structure, .model = support::piezo_model(), .pi = pi});
  support::restart_at_lower_threshold(result, 1.5);
  return result;
}

/// Runs one cycle and applies the requested drive.
double step(ControlLaw& law, double reference_um, double previewed_um, std::optional<double> position_um) {
  const ControlLaw::Demand demand = law.propose(
      {.reference_um = reference_um, .previewed_um = previewed_um, .position_um = position_um, .dt_s = dt_s});
  law.commit(demand.drive);
  return demand.drive;
}

// After five missed cycles, the error is that of the pause. Over 6 ms it would change the integral by 0.6
// times the error.
TEST(ControlLaw, DoesNotIntegrateMissedCycles) {
  ControlLaw paused = law(Structure::inverse_pi), steady = law(Structure::inverse_pi);
  const auto after = [](ControlLaw& of, double elapsed_s) {
    const double before_um = of.integral_um();
    const ControlLaw::Demand demand = of.propose({.reference_um = 12.0,
                                                  .previewed_um = 12.0,
                                                  .position_um = 11.0,
                                                  .dt_s = elapsed_s,
                                                  .cycle_s = dt_s});
    of.commit(demand.drive);
    return of.integral_um() - before_um;
  };
  EXPECT_DOUBLE_EQ(after(paused, 6.0 * dt_s), after(steady, dt_s));
}

TEST(ControlLaw, InverseDrivesTheModelToThePreviewedReference) {
  ControlLaw feed_forward = law(Structure::inverse);
  const model::Hysteresis actuator(support::piezo_model());
  model::HysteresisState state = actuator.at_lower_threshold();
  for (const double wanted_um : {5.0, 20.0, 8.0, 17.0, 9.0, 25.0, 3.0}) {
    actuator.advance(state, step(feed_forward, 0.0, wanted_um, std::nullopt));
    EXPECT_NEAR(state.output, wanted_um, 1e-10);
  }
}

TEST(ControlLaw, AverageInvertsTheMeanCurveForAnyHistory) {
  ControlLaw feed_forward = law(Structure::average);
  const model::HysteresisParameters model = support::piezo_model();
  for (const double wanted_um : {5.0, 20.0, 8.0, 17.0}) {
    const double drive = step(feed_forward, 0.0, wanted_um, std::nullopt);
    EXPECT_NEAR(0.5 * (model.ascending.value(drive) + model.descending.value(drive)), wanted_um, 1e-10);
  }
}

TEST(ControlLaw, IntegralActsInDisplacementUnits) {
  ControlLaw both = law(Structure::inverse_pi);  // sensor and model agree at the start: no integral
  step(both, 10.0, 10.0, 9.0);
  const ControlLaw::Demand second =
      both.propose({.reference_um = 10.0, .previewed_um = 10.0, .position_um = 9.0, .dt_s = dt_s});
  EXPECT_NEAR(second.position_um, 10.0 + 2 * 100.0 * 1.0 * dt_s, 1e-12);  // two cycles of ki e dt
}

TEST(ControlLaw, BridgesALostSampleWithTheLastErrorWithoutIntegrating) {
  ControlLaw both = law(Structure::inverse_pi, {.kp = 0.5, .ki_per_s = 100.0});
  step(both, 10.0, 10.0, 9.0);
  const ControlLaw::Demand bridged =
      both.propose({.reference_um = 10.0, .previewed_um = 10.0, .position_um = std::nullopt, .dt_s = dt_s});
  EXPECT_NEAR(bridged.position_um, 10.0 + 0.5 * 1.0 + 100.0 * 1.0 * dt_s, 1e-12);
}

// The loop between the virgin curve and a turning point 1e-310 V above its start is 1.5 um high: its
// exponential overflows.
TEST(ControlLaw, FlagsADriveOnABranchThatDoesNotIncrease) {
  ControlLaw feed_forward = law(Structure::inverse);
  const model::Hysteresis actuator(support::piezo_model());
  model::HysteresisState memory = actuator.virgin(0.0);
  actuator.advance(memory, 1e-310);
  for (const bool turned : {false, true}) {
    if (turned) actuator.advance(memory, 5e-311);
    feed_forward.remember(memory);
    const ControlLaw::Demand demand = feed_forward.propose({.reference_um = memory.output,
                                                            .previewed_um = memory.output,
                                                            .position_um = std::nullopt,
                                                            .dt_s = dt_s});
    EXPECT_EQ(demand.limits & limit::not_invertible, turned ? limit::not_invertible : limit::none);
  }
}

TEST(ControlLaw, MemoryFollowsTheAppliedDriveAndNotTheRequestedDrive) {
  ControlLaw feed_forward = law(Structure::inverse);
  feed_forward.propose(
      {.reference_um = 0.0, .previewed_um = 20.0, .position_um = std::nullopt, .dt_s = dt_s});
  feed_forward.commit(30.0);
  const model::Hysteresis actuator(support::piezo_model());
  model::HysteresisState state = actuator.at_lower_threshold();
  actuator.advance(state, 30.0);
  EXPECT_DOUBLE_EQ(feed_forward.predicted_um(), state.output);
}

TEST(Structure, NamesAreParsedBackToTheirStructure) {
  for (const Structure structure : all_structures)
    EXPECT_EQ(parse_word<Structure>(to_string(structure)), structure);
  EXPECT_EQ(parse_word<Structure>("pid"), std::nullopt);
}

}  // namespace
}  // namespace hystcan::controller::law_test
