// The floor, compared with known figures and with a least-squares fit in the time domain.
#include "controller/analysis/feed_forward_design.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "model/second_order.h"

namespace hystcan::controller::tracking_floor_test {
namespace {

constexpr double cycle_s = 1e-3;
constexpr double stroke_um = 30.0;

Delays stage(bool interpolated) {
  return {.command_delay = std::chrono::milliseconds(1),
          .amplifier_bandwidth_Hz = 1500.0,
          .resonance_Hz = 500.0,
          .damping_ratio = 0.05,
          .interpolated = interpolated};
}

double triangle_percent(double frequency_Hz, bool interpolated) {
  const Shape triangle =
      Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = frequency_Hz, .cycles = 10.0};
  return 100.0 * tracking_floor_um(stage(interpolated), cycle_s, triangle).value() / stroke_um;
}

TEST(TrackingFloor, MatchesTheDocumentedValuesForATriangle) {
  EXPECT_NEAR(triangle_percent(10.0, false), 0.101, 0.05 * 0.101);
  EXPECT_NEAR(triangle_percent(10.0, true), 0.039, 0.05 * 0.039);
  EXPECT_NEAR(triangle_percent(50.0, false), 0.52, 0.05 * 0.52);
  EXPECT_NEAR(triangle_percent(50.0, true), 0.43, 0.05 * 0.43);
}

/// Returns the position of the last of many periods at every fine step, with a setpoint of 1 in the first
/// cycle of each period.
Eigen::VectorXd response_to_one_setpoint(const Delays& delays, int cycles, int per_cycle) {
  const double dt_s = cycle_s / per_cycle;
  const double lag = std::exp(-2.0 * std::numbers::pi * delays.amplifier_bandwidth_Hz * dt_s);
  const model::SecondOrder mode({delays.resonance_Hz, delays.damping_ratio}, dt_s);
  model::SecondOrder::State state;
  double output = 0.0;
  Eigen::VectorXd position(cycles * per_cycle);
  for (int period = 0; period < 40; ++period) {
    for (int i = 0; i < cycles * per_cycle; ++i) {
      position[i] = state.position;
      const int cycle = i / per_cycle;
      const double part = (i % per_cycle + 0.5) / per_cycle;
      const double held = cycle == 0 ? 1.0 : 0.0, straight = cycle == 0   ? part
                                                             : cycle == 1 ? 1.0 - part
                                                                          : 0.0;
      const double target = delays.interpolated ? straight : held;
      const double before = output;
      output = target + (output - target) * lag;
      state = mode(state, before, output);
    }
  }
  return position;
}

// Steps of 5 us with linear inputs: 1 % of the floor.
TEST(TrackingFloor, IsTheLeastErrorOfAllSequencesOfSetpoints) {
  constexpr int cycles = 20, per_cycle = 200;
  for (const bool interpolated : {false, true}) {
    const Eigen::VectorXd one = response_to_one_setpoint(stage(interpolated), cycles, per_cycle);
    Eigen::MatrixXd all(one.size(), cycles);
    Eigen::VectorXd reference(one.size());
    const Shape triangle = Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 50.0, .cycles = 1.0};
    for (Eigen::Index i = 0; i < one.size(); ++i) {
      reference[i] = value_um(triangle, static_cast<double>(i) * cycle_s / per_cycle);
      for (int k = 0; k < cycles; ++k) all(i, k) = one[(i + one.size() - k * per_cycle) % one.size()];
    }
    const Eigen::VectorXd best = (all.transpose() * all).ldlt().solve(all.transpose() * reference);
    const double least_um = (reference - all * best).norm() / std::sqrt(static_cast<double>(one.size()));
    const double floor_um = tracking_floor_um(stage(interpolated), cycle_s, triangle).value();
    EXPECT_NEAR(floor_um, least_um, 0.01 * least_um) << interpolated;
  }
}

TEST(TrackingFloor, IsFarLowerForASineThanForATriangle) {
  const Shape sine = Sine{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 10.0};
  EXPECT_LT(100.0 * tracking_floor_um(stage(true), cycle_s, sine).value() / stroke_um,
            0.1 * triangle_percent(10.0, true));
}

TEST(TrackingFloor, IsGivenOnlyForShapesThatRepeatInAWholeNumberOfCycles) {
  EXPECT_FALSE(tracking_floor_um(stage(false), cycle_s, Hold{}));
  EXPECT_TRUE(tracking_floor_um(stage(false), cycle_s, Triangle{.frequency_Hz = 30.0}))
      << "3 periods in 100 cycles";
  EXPECT_FALSE(tracking_floor_um(stage(false), cycle_s, Triangle{.frequency_Hz = std::numbers::pi}));
}

}  // namespace
}  // namespace hystcan::controller::tracking_floor_test
