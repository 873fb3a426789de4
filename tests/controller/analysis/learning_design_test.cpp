// The filter of the learning: its condition of convergence, and its effect in virtual cycles.
#include "controller/analysis/learning_design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "tests/controller/analysis/simulated_loop.h"
#include "tests/support/refusal.h"

namespace hystcan::controller::learning_design_test {
namespace {

LoopConfig stage(double resonance_Hz, double damping_ratio, double ki_per_s = 200.0) {
  return {.delays = {.command_delay = std::chrono::milliseconds(1),
                     .amplifier_bandwidth_Hz = 1500.0,
                     .resonance_Hz = resonance_Hz,
                     .damping_ratio = damping_ratio},
          .pi = {.ki_per_s = ki_per_s}};
}

Triangle triangle(double frequency_Hz) {
  return {.low_um = -10.0, .high_um = 10.0, .frequency_Hz = frequency_Hz, .cycles = 1e4};
}

Learning::Config learning(double resonance_percent) {
  return {.correction_max_um = 5.0, .resonance_percent = resonance_percent};
}

/// |1 - forget - rate H T| of the designed taps for a plant with `factor` times the stated resonance.
double growth(const LearningDesign& design, const Learning::Config& config, LoopConfig loop, double factor,
              double theta) {
  const double ahead = std::round(chain_moments(loop.delays, loop.notch, loop.cycle_s).mean_s / loop.cycle_s);
  loop.delays.resonance_Hz *= factor;
  const LinearLoop linear(loop);
  const std::complex<double> path = linear.plant(theta), l = linear(loop.pi, theta);
  const auto t = (path * std::polar(1.0, theta * ahead) + l) / (1.0 + l);
  std::complex<double> h = 0.0;
  const int late = static_cast<int>(design.plan.taps.size() / 2);
  for (int k = -late; k <= late; ++k)
    h += design.plan.taps[static_cast<std::size_t>(k + late)] * std::polar(1.0, theta * k);
  return std::abs(1.0 - 0.01 * config.forget_percent - config.rate * h * t);
}

// The condition of docs/theory/control_law.md, for every harmonic and every resonance within the stated
// interval.
TEST(LearningDesign, ConvergesAtEveryHarmonicForEveryResonanceInItsInterval) {
  for (const double resonance_Hz : {130.0, 220.0, 410.0, 500.0, 730.0})
    for (const double damping_ratio : {0.02, 0.05, 0.3})
      for (const double percent : {1.0, 5.0, 10.0}) {
        LoopConfig loop = stage(resonance_Hz, damping_ratio);
        if (resonance_Hz < 400.0)
          loop.notch =
              Notch::Config{.frequency_Hz = resonance_Hz, .depth = 2.0 * damping_ratio, .width = 1.0};
        const Learning::Config config = learning(percent);
        const LearningDesign design = design_learning(loop, triangle(7.0), config);
        for (const double off : {-1.0, -0.37, 0.0, 0.51, 1.0})
          for (int harmonic = 1; harmonic < 71; ++harmonic)
            EXPECT_LT(growth(design, config, loop, 1.0 + 0.01 * percent * off,
                             2.0 * std::numbers::pi * 0.007 * harmonic),
                      1.0)
                << resonance_Hz << " Hz " << damping_ratio << ", " << percent << " % * " << off
                << ", harmonic " << harmonic;
      }
}

// Without feed-forward, the correction acts only through PI, T = L / (1 + L); without PI, only through the
// feed-forward.
TEST(LearningDesign, ConvergesForEveryStructure) {
  for (const Structure structure : all_structures) {
    LoopConfig loop = stage(500.0, 0.05);
    loop.structure = structure;
    const Learning::Config config = learning(5.0);
    const LearningDesign design = design_learning(loop, triangle(10.0), config);
    const LinearLoop linear(loop);
    const double ahead =
        std::round(chain_moments(loop.delays, loop.notch, loop.cycle_s).mean_s / loop.cycle_s);
    for (int harmonic = 1; harmonic < 50; ++harmonic) {
      const double theta = 2.0 * std::numbers::pi * 0.01 * harmonic;
      const std::complex<double> forward =
          feeds_forward(structure) ? linear.plant(theta) * std::polar(1.0, theta * ahead) : 0.0;
      const std::complex<double> feedback = feeds_back(structure) ? linear(loop.pi, theta) : 0.0;
      std::complex<double> h = 0.0;
      const int late = static_cast<int>(design.plan.taps.size() / 2);
      for (int k = -late; k <= late; ++k)
        h += design.plan.taps[static_cast<std::size_t>(k + late)] * std::polar(1.0, theta * k);
      EXPECT_LT(std::abs(1.0 - config.rate * h * (forward + feedback) / (1.0 + feedback)), 1.0)
          << to_string(structure) << ", harmonic " << harmonic;
    }
  }
}

TEST(LearningDesign, LearnsFewerHarmonicsIfTheResonanceIsUncertain) {
  const LoopConfig loop = stage(220.0, 0.05, 60.0);
  double before_Hz = 1e9;
  for (const double percent : {1.0, 5.0, 15.0}) {
    const LearningDesign design = design_learning(loop, triangle(10.0), learning(percent));
    EXPECT_LE(design.highest_Hz, before_Hz) << percent;
    before_Hz = design.highest_Hz;
  }
  EXPECT_LT(before_Hz, 220.0);
}

TEST(LearningDesign, CombinesPeriodsIntoAWholeNumberOfCycles) {
  const auto designed = [](double frequency_Hz) {
    return design_learning(stage(500.0, 0.05), triangle(frequency_Hz), learning(10.0));
  };
  EXPECT_EQ(designed(10.0).plan.phases, 100u);
  EXPECT_EQ(designed(30.0).plan.phases, 100u) << "three periods";
  EXPECT_EQ(designed(30.0).periods, 3u);
  EXPECT_NEAR(designed(7.3).slip_cycles, 1.0 / 73.0, 1e-6);
  EXPECT_EQ(designed(7.3).plan.phases, 137u);
}

TEST(LearningDesign, RefusesShapesThatCannotBeLearnt) {
  const auto refusal = [](const Shape& shape) {
    return support::refusal_of<std::invalid_argument>(
        [&] { design_learning(stage(500.0, 0.05), shape, learning(10.0)); });
  };
  EXPECT_NE(refusal(Hold{}).find("a hold does not repeat"), std::string::npos) << refusal(Hold{});
  EXPECT_NE(refusal(triangle(400.0)).find("a period of 2.5 cycles"), std::string::npos);
  EXPECT_NE(refusal(triangle(0.01)).find("a period of 1e+05"), std::string::npos) << refusal(triangle(0.01));
  Triangle few = triangle(10.0);
  few.cycles = 2.0;
  EXPECT_NE(refusal(few).find("2 periods, expected 2.5 or more"), std::string::npos) << refusal(few);
}

TEST(LearningPlan, IsMadeForTheSegmentsThatRepeat) {
  AxisConfig axis;
  axis.delays = stage(500.0, 0.05).delays;
  axis.law.pi = {.ki_per_s = 200.0};
  axis.setpoint = {{.shape = triangle(10.0)}, {.shape = Hold{}}};
  axis.learning = learning(10.0);
  const auto designs = plan_learning(axis, 1000.0);
  EXPECT_TRUE(designs[0]);
  EXPECT_FALSE(designs[1]);
  EXPECT_EQ(axis.learning->ahead_cycles, 2u) << "one of the command, half of the hold, and the lags";
  axis.setpoint.erase(axis.setpoint.begin());
  EXPECT_THROW(plan_learning(axis, 1000.0), std::invalid_argument);
}

}  // namespace
}  // namespace hystcan::controller::learning_design_test
