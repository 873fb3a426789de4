// Bandwidth, delay, characteristic and noise of the sensor, compared with their closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/twin/twin_bench.h"
#include "twin/sensor.h"

namespace hystcan::twin::sensor_physics_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr double two_pi = 2.0 * std::numbers::pi;
constexpr microseconds substep{50};
constexpr can::Time start{};

can::Time grid(int n) { return start + n * substep; }

/// The sensor follows `position(seconds)` from 0 to grid point n.
template <class Position>
void follow(Sensor& sensor, int n, const Position& position) {
  for (int i = 0; i <= n; ++i) sensor.follow(grid(i), position(can::seconds(i * substep)));
}

TEST(SensorBandwidth, IsExactForARamp) {
  Sensor sensor({.bandwidth_Hz = 300.0}, 1, start, substep);
  const double omega = two_pi * 300.0;
  const auto ramp = [](double t_s) { return 2.0 + 1000.0 * t_s; };
  follow(sensor, 40, ramp);
  for (const int off_grid_us : {0, 1, 17, 50}) {
    const double t_s = can::seconds(40 * substep + microseconds(off_grid_us));
    const double expected = ramp(t_s) - 1000.0 / omega * (1.0 - std::exp(-omega * t_s));
    EXPECT_NEAR(sensor.measure(grid(40) + microseconds(off_grid_us), ramp(t_s)).position_um, expected, 1e-12);
  }
}

// The position is linear between grid points, which reduces a sine of 100 Hz by (omega dt)^2 / 12 = 7e-4 %.
TEST(SensorBandwidth, AttenuatesByThreeDecibelAndDelaysByAnEighthOfAPeriod) {
  Sensor sensor({.bandwidth_Hz = 100.0}, 1, start, substep);
  const auto sine = [](double t_s) { return std::sin(two_pi * 100.0 * t_s); };
  follow(sensor, 4000, sine);
  for (int i = 4001; i <= 4200; ++i) {
    const double t_s = can::seconds(i * substep);
    sensor.follow(grid(i), sine(t_s));
    const double expected = std::sqrt(0.5) * std::sin(two_pi * 100.0 * t_s - 0.25 * std::numbers::pi);
    ASSERT_NEAR(sensor.measure(grid(i), sine(t_s)).position_um, expected, 1e-4);
  }
}

TEST(SensorBandwidth, IsNotChangedByAReading) {
  Sensor read({.bandwidth_Hz = 200.0, .delay = microseconds(130)}, 1, start, substep);
  Sensor left_alone({.bandwidth_Hz = 200.0, .delay = microseconds(130)}, 1, start, substep);
  const auto position = [](int n) { return std::sin(0.1 * n); };
  for (int n = 0; n < 200; ++n) {
    read.follow(grid(n), position(n));
    left_alone.follow(grid(n), position(n));
    read.measure(grid(n) + microseconds(n % 50), 7.0);
    ASSERT_EQ(read.measure(grid(n), position(n)).position_um,
              left_alone.measure(grid(n), position(n)).position_um);
  }
}

TEST(SensorDelay, ReadsThePositionOneDelayEarlier) {
  for (const int delay_us : {1, 49, 50, 51, 100, 333, 1000}) {
    Sensor sensor({.delay = microseconds(delay_us)}, 1, start, substep);
    const auto ramp = [](double t_s) { return 1000.0 * t_s; };
    follow(sensor, 100, ramp);
    for (const int off_grid_us : {0, 13, 50}) {
      const double t_s = can::seconds(100 * substep + microseconds(off_grid_us));
      EXPECT_NEAR(sensor.measure(grid(100) + microseconds(off_grid_us), ramp(t_s)).position_um,
                  ramp(t_s - 1e-6 * delay_us), 1e-12)
          << delay_us << " us, read " << off_grid_us << " us after a grid point";
    }
  }
}

TEST(SensorDelay, ReadsTheInitialPositionBeforeItsFirstGridPoint) {
  Sensor sensor({.delay = milliseconds(1)}, 1, start, substep);
  EXPECT_EQ(sensor.measure(start, 3.0).position_um, 3.0) << "no grid point is known yet";
  sensor.follow(start, 3.0);
  sensor.follow(grid(1), 5.0);
  EXPECT_EQ(sensor.measure(grid(1), 5.0).position_um, 3.0);
}

// A rest is one long sub-step.
TEST(SensorDelay, IsTheSameAfterARest) {
  Sensor sensor({.delay = microseconds(100)}, 1, start, substep);
  sensor.follow(start, 3.0);
  sensor.follow(grid(1'000'000), 3.0);
  for (int n = 1; n <= 3; ++n) sensor.follow(grid(1'000'000 + n), 3.0 + n);
  EXPECT_NEAR(sensor.measure(grid(1'000'003), 6.0).position_um, 4.0, 1e-12);
}

TEST(SensorCharacteristic, HasASineErrorWithZeroEnds) {
  Sensor sensor({.nonlinearity_percent = 0.2, .range_min_um = -5.0, .range_max_um = 35.0}, 1);
  const auto error_um = [&](double x) { return sensor.measure(start, x).position_um - x; };
  EXPECT_NEAR(error_um(-5.0), 0.0, 1e-14);
  EXPECT_NEAR(error_um(5.0), 0.002 * 40.0, 1e-14);
  EXPECT_NEAR(error_um(15.0), 0.0, 1e-14);
  EXPECT_NEAR(error_um(25.0), -0.002 * 40.0, 1e-14);
  EXPECT_NEAR(error_um(35.0), 0.0, 1e-14);
}

TEST(SensorCharacteristic, HasAGainAnOffsetAndADrift) {
  Sensor sensor({.drift_um_per_h = 0.036, .gain_error_percent = -0.5, .offset_um = 0.25}, 1, start);
  EXPECT_NEAR(sensor.measure(start, 20.0).position_um, 20.0 - 0.1 + 0.25, 1e-14);
  EXPECT_NEAR(sensor.measure(start + std::chrono::seconds(100), 20.0).position_um, 20.15 + 0.001, 1e-14);
}

TEST(SensorCharacteristic, SaturatesBeyondItsRangeAndReportsIt) {
  Sensor sensor({.range_min_um = -1.0, .range_max_um = 31.0}, 1);
  EXPECT_TRUE(sensor.measure(start, 31.0).in_range);
  const Sensor::Reading above = sensor.measure(start, 31.5);
  EXPECT_EQ(above.position_um, 31.0);
  EXPECT_FALSE(above.in_range);
  EXPECT_FALSE(sensor.measure(start, -1.5).in_range);
}

// The correlation time is 1.6 samples, so about 40 000 of 100 000 samples are independent. The tolerance is
// five standard errors.
TEST(SensorNoise, HasTheSpreadOfItsDensityAndTheCorrelationOfItsBandwidth) {
  Sensor sensor({.noise_density_um_per_rtHz = 1e-4, .bandwidth_Hz = 100.0}, 42);
  const double rms = 1e-4 * std::sqrt(0.5 * std::numbers::pi * 100.0);
  const double rho = std::exp(-two_pi * 100.0 * 1e-3);
  constexpr int samples = 100'000;
  std::vector<double> noise;
  noise.reserve(samples);
  for (int i = 0; i < samples; ++i)
    noise.push_back(sensor.measure(start + milliseconds(i), 5.0).position_um - 5.0);
  double squares = 0.0;
  double products = 0.0;
  for (std::size_t i = 1; i < noise.size(); ++i) {
    squares += noise[i] * noise[i];
    products += noise[i] * noise[i - 1];
  }
  EXPECT_NEAR(std::sqrt(squares / samples), rms, 5 * rms / std::sqrt(2.0 * 40'000));
  EXPECT_NEAR(products / squares, rho, 5 / std::sqrt(40'000.0));
}

TEST(SensorNoise, IsConstantWithinTheSameTime) {
  Sensor sensor({.noise_density_um_per_rtHz = 1e-4, .bandwidth_Hz = 100.0}, 1);
  const double first = sensor.measure(start, 5.0).position_um;
  EXPECT_NE(first, 5.0);
  EXPECT_EQ(sensor.measure(start, 5.0).position_um, first);
}

TEST(SensorOnTheBus, MarksASampleBeyondItsRangeInTheStatus) {
  Config config = one_axis();
  config.axes.front().axis.sensor.range_min_um = -1.0;
  config.axes.front().axis.sensor.range_max_um = 6.0;
  TwinBench bench(config);
  bench.start_nodes();
  bench.drive(10.0, 30);
  EXPECT_EQ(bench.sample_->status, 0);
  bench.drive(60.0, 30);
  EXPECT_EQ(bench.sample_->status, node::sensor_status::out_of_range);
  EXPECT_NEAR(bench.sample_->position_um, 6.0, 1e-6);
}

TEST(SensorOnTheBus, ReadsThePlantWithItsDelay) {
  Config delayed = one_axis();
  delayed.axes.front().axis.sensor.delay = milliseconds(3);
  TwinBench late(delayed);
  TwinBench prompt;
  for (TwinBench* bench : {&late, &prompt}) bench->start_nodes();
  std::vector<double> seen;
  for (int i = 0; i < 40; ++i) {
    const double setpoint = 40.0 + 30.0 * std::sin(0.4 * i);
    late.drive(setpoint, 1);
    prompt.drive(setpoint, 1);
    seen.push_back(prompt.sample_->position_um);
    if (i < 3) continue;
    // The position is linear between grid points; a mode of 500 Hz deviates from that by at most
    //   x'' dt^2 / 8 = 10 um * (2 pi 500)^2 * 3e-10 s^2
    ASSERT_NEAR(late.sample_->position_um, seen[seen.size() - 4], 0.03) << "cycle " << i;
  }
}

TEST(SensorOnTheBus, SamplesByItsOwnClockAndNamesTheLastSync) {
  Config config = one_axis();
  config.axes.front().axis.sample_clock = {
      .sampling = node::Sampling::free, .rate_Hz = 1000.0, .skew_ppm = 10'000.0};
  TwinBench bench(config);
  bench.start_nodes();
  bench.run(milliseconds(10));
  EXPECT_EQ(bench.heard_[0x182], 0) << "no SYNC has been received";
  bench.sync();
  bench.run(milliseconds(1000));
  EXPECT_NEAR(bench.heard_[0x182], 1010, 1) << "one SYNC, samples at 1010 Hz";
  EXPECT_EQ(bench.sample_->sync_counter, bench.counter_);
  bench.tester_->send(can::nmt_frame({can::NmtCommand::stop, 2}));
  bench.run(milliseconds(1));
  const int until_stopped = bench.heard_[0x182];
  bench.run(milliseconds(10));
  EXPECT_EQ(bench.heard_[0x182], until_stopped) << "not operational";
}

}  // namespace
}  // namespace hystcan::twin::sensor_physics_test
