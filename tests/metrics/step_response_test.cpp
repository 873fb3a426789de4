#include "metrics/step_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace hystcan::metrics::step_response_test {
namespace {

/// Rests at 10 um, steps to 20 um at 0.1 s; the stage responds with a mode of 20 Hz.
struct Answer {
  double damping = 0.2;
  double radians(double t_s) const { return 2.0 * M_PI * 20.0 * (t_s - 0.1); }
  double position_um(double t_s) const {
    if (t_s < 0.1) return 10.0;
    return 20.0 - 10.0 * std::exp(-damping * radians(t_s)) * std::cos(radians(t_s));
  }
};

StepResponse respond(const Answer& answer, double band_um, double until_s) {
  StepResponse response(band_um);
  for (double t_s = 0.0; t_s < until_s; t_s += 1e-3)
    response.add(t_s, t_s < 0.0995 ? 10.0 : 20.0, answer.position_um(t_s), true);
  return response;
}

TEST(StepResponse, HasTheOvershootOfTheStepInItsDirection) {
  const auto result = respond({}, 0.1, 1.0).result();
  EXPECT_EQ(result.steps, 1u);
  EXPECT_NEAR(result.overshoot, std::exp(-0.2 * M_PI), 0.02) << "half a period later; sampled";
}

TEST(StepResponse, SettlesWhenTheErrorStaysWithinTheBand) {
  const double envelope_s = std::log(10.0 / 0.1) / (0.2 * 2.0 * M_PI * 20.0);
  const auto result = respond({}, 0.1, 1.0).result();
  EXPECT_EQ(result.not_settled, 0u);
  EXPECT_LE(result.settling_s, envelope_s + 1e-3);
  EXPECT_GE(result.settling_s, envelope_s - 0.026) << "half a period before the envelope is inside";
}

TEST(StepResponse, UsesAHundredthOfTheStepByDefault) {
  EXPECT_EQ(respond({}, 0.0, 1.0).result().settling_s, respond({}, 0.1, 1.0).result().settling_s);
}

TEST(StepResponse, HasNotSettledIfItEndsOutsideTheBand) {
  EXPECT_EQ(respond({}, 0.1, 0.2).result().not_settled, 1u);
}

TEST(StepResponse, NeedsALevelBeforeTheStep) {
  StepResponse response(0.1);
  response.add(0.0, 10.0, 5.0, true);
  EXPECT_EQ(response.result().steps, 0u);
  response.leave();
  response.add(0.1, 20.0, 5.0, true);
  EXPECT_EQ(response.result().steps, 0u) << "what was before the segment is no level of it";
}

TEST(StepResponse, CountsTheMoveOfARampToTheNextLevel) {
  StepResponse response(0.1);
  response.add(0.0, 10.0, 10.0, true);
  response.add(0.1, 12.0, 11.0, false);
  response.add(0.2, 14.0, 14.0, true);
  EXPECT_EQ(response.result().steps, 1u);
  EXPECT_EQ(response.result().settling_s, 0.0);
}

/// Second-order response to a step from 2 to 12 at 0.1 s: damping 0.5, 10 Hz.
TEST(StepResponse, HasRiseOvershootAndSettlingForARecord) {
  std::vector<double> time_s, reference, position;
  const double omega = 62.83, damping = 0.5, damped = omega * std::sqrt(1.0 - damping * damping);
  for (int i = 0; i < 1100; ++i) {
    const double t = 1e-3 * i, since = t - 0.1;
    time_s.push_back(t);
    reference.push_back(since < 0.0 ? 2.0 : 12.0);
    position.push_back(since < 0.0 ? 2.0
                                   : 12.0 - 10.0 * std::exp(-damping * omega * since) *
                                                (std::cos(damped * since) +
                                                 damping * omega / damped * std::sin(damped * since)));
  }
  std::size_t begin = 0;
  const auto step = largest_step({time_s, reference, position}, 0.2, begin);

  ASSERT_TRUE(step);
  EXPECT_EQ(begin, 100U);
  EXPECT_EQ(step->from_um, 2.0);
  EXPECT_EQ(step->to_um, 12.0);
  EXPECT_NEAR(step->overshoot(), 0.163, 0.001);
  ASSERT_TRUE(step->rise_s() && step->settling_s());
  EXPECT_NEAR(*step->rise_s(), 1.64 / omega, 1.1e-3);
  EXPECT_NEAR(*step->settling_s(), 8.08 / omega, 2e-3);
}

/// The controller follows the cycles; `plot` and the page use the record.
TEST(StepResponse, IsEqualCycleByCycleAndFromARecord) {
  const Answer answer;
  for (const double tolerance_um : {0.0, 0.3}) {
    StepResponse followed(tolerance_um);
    std::vector<double> time_s, reference_um, position_um;
    for (int i = 0; i < 1000; ++i) {
      time_s.push_back(1e-3 * i);
      reference_um.push_back(i < 100 ? 10.0 : 20.0);
      position_um.push_back(answer.position_um(time_s.back()));
      followed.add(time_s.back(), reference_um.back(), position_um.back(), true);
    }
    std::size_t begin = 0;
    const auto recorded = largest_step({time_s, reference_um, position_um}, tolerance_um, begin);
    ASSERT_TRUE(recorded);
    EXPECT_EQ(recorded->settling_s(), followed.result().settling_s);
    EXPECT_EQ(recorded->overshoot(), followed.result().overshoot);
  }
}

/// Rests at 2 um, steps to 3, moves to 7 in 30 cycles, steps back to 5, and is at 15 after a transition.
struct Staircase {
  std::vector<double> time_s, reference_um;
  Staircase() {
    for (const double level_um : {2.0, 3.0}) add(100, level_um);
    for (int i = 1; i < 30; ++i) add(1, 3.0 + 4.0 * i / 30.0);
    for (const double level_um : {7.0, 5.0}) add(100, level_um);
    add(200, std::nan(""));
    add(100, 15.0);
  }
  void add(int cycles, double um) {
    while (cycles-- > 0)
      reference_um.push_back(um), time_s.push_back(1e-3 * static_cast<double>(time_s.size()));
  }
};

TEST(StepResponse, UsesTheLargestMoveOfARecord) {
  const Staircase stairs;
  std::size_t begin = 0;
  const auto step = largest_step({stairs.time_s, stairs.reference_um, stairs.reference_um}, 0.0, begin);
  ASSERT_TRUE(step);
  EXPECT_EQ(step->from_um, 3.0);
  EXPECT_EQ(step->to_um, 7.0);
  EXPECT_EQ(begin, 229U) << "where it comes to rest";
  EXPECT_EQ(step->cycles, 100U);
}

TEST(StepResponse, UsesTheMoveThatContainsAGivenCycle) {
  const Staircase stairs;
  const Cycles cycles{stairs.time_s, stairs.reference_um, stairs.reference_um};
  for (const std::size_t on_its_way : {200U, 210U, 229U}) {
    ASSERT_TRUE(step_at(cycles, on_its_way, 0.0)) << on_its_way;
    EXPECT_EQ(step_at(cycles, on_its_way, 0.0)->to_um, 7.0);
  }
  EXPECT_FALSE(step_at(cycles, 230, 0.0));
  EXPECT_FALSE(step_at(cycles, 99, 0.0));
  EXPECT_EQ(step_at(cycles, 100, 0.0)->to_um, 3.0);
}

TEST(StepResponse, IsNotFoundInATriangle) {
  std::vector<double> time_s, reference;
  for (int i = 0; i < 1000; ++i) time_s.push_back(1e-3 * i), reference.push_back(std::abs(i % 200 - 100));
  std::size_t begin = 0;
  EXPECT_FALSE(largest_step({time_s, reference, reference}, 0.0, begin));
}

TEST(HoldNoise, IsTheDeviationFromTheMeanOfEachLevel) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise_um(0.0, 0.02);
  HoldNoise noise;
  for (const double level_um : {5.0, 25.0, 10.0})
    for (int n = 0; n < 3000; ++n) noise.add(level_um, level_um - 0.3 + noise_um(random), 1.0, true);
  EXPECT_EQ(noise.samples(), 9000u);
  EXPECT_NEAR(noise.rms_um(), 0.02, 0.001);
}

TEST(HoldNoise, IgnoresSamplesOutsideTheBandOrInMotion) {
  HoldNoise noise;
  noise.add(5.0, 9.0, 1.0, true);
  noise.add(7.0, 7.0, 1.0, false);
  EXPECT_EQ(noise.samples(), 0u);
  noise.add(5.0, 5.1, 1.0, true);
  noise.add(5.0, 5.1, 1.0, true);
  EXPECT_EQ(noise.samples(), 2u);
  EXPECT_EQ(noise.rms_um(), 0.0);
  noise.add(5.0, 9.0, 1.0, true);
  EXPECT_EQ(noise.samples(), 0u) << "it had not settled";
}

TEST(HoldNoise, HasNoValueIfTheNoiseIsAsLargeAsTheBand) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise_um(0.0, 0.05);
  HoldNoise noise;
  for (const double level_um : {5.0, 25.0, 10.0}) {
    for (int n = 0; n < 3000; ++n) {
      noise.add(level_um, level_um + noise_um(random), 0.05, true);
      EXPECT_TRUE(n < 100 || noise.samples() == 0) << n;
    }
  }
}

}  // namespace
}  // namespace hystcan::metrics::step_response_test
