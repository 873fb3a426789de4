// A loop in the time domain: PI, low pass and notch of the control law around a finely stepped plant.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <deque>
#include <numbers>
#include <string>
#include <vector>

#include "controller/analysis/linear_loop.h"

namespace hystcan::controller::simulated {

inline std::vector<LoopConfig> loops() {
  const Delays piezo{.command_delay = std::chrono::milliseconds(1),
                     .amplifier_bandwidth_Hz = 1500.0,
                     .resonance_Hz = 410.0,
                     .damping_ratio = 0.05};
  LoopConfig plain{.delays = piezo}, notched = plain, filtered = plain, sensor = plain, interpolated = plain;
  notched.notch = Notch::Config{.frequency_Hz = 400.0, .depth = 0.1, .width = 0.5};
  filtered.measurement_filter_Hz = 80.0;
  sensor.delays.sensor_delay = std::chrono::microseconds(400);
  sensor.delays.sensor_bandwidth_Hz = 300.0;
  interpolated.delays.interpolated = true;
  return {plain, notched, filtered, sensor, interpolated};
}

inline std::string name_of(const LoopConfig& config) {
  return config.notch                              ? "notched"
         : config.measurement_filter_Hz > 0.0      ? "filtered"
         : config.delays.sensor_bandwidth_Hz > 0.0 ? "with a sensor"
         : config.delays.interpolated              ? "interpolated"
                                                   : "plain";
}

/// The plant in steps of a thousandth of a cycle.
class FinePlant {
 public:
  explicit FinePlant(const LoopConfig& config) : config_(config) {}

  /// Advances by one cycle with this demand.
  void step(double demand) {
    late_.push_back(demand);
    const auto& d = config_.delays;
    const double dt_s = config_.cycle_s / fine;
    const double delay_s = std::chrono::duration<double>(d.command_delay + d.sensor_delay).count();
    const double cycles = std::floor(delay_s / config_.cycle_s + 1e-9);
    const int from = static_cast<int>(std::lround((delay_s / config_.cycle_s - cycles) * fine));
    for (int i = 0; i < fine; ++i) {
      const std::size_t newest = late_.size() - 1 - static_cast<std::size_t>(cycles);
      const bool is_new = i >= from;
      const double now = late_[is_new ? newest : newest - 1],
                   before = late_[is_new ? newest - 1 : newest - 2];
      const double part = (i - from + (is_new ? 0.5 : fine + 0.5)) / fine;
      move(d.interpolated ? before + part * (now - before) : now, dt_s);
    }
    late_.pop_front();
  }
  double sample() const { return config_.delays.sensor_bandwidth_Hz > 0.0 ? sensed_ : position_; }

 private:
  static constexpr int fine = 1000;

  void move(double setpoint, double dt_s) {
    constexpr double two_pi = 2.0 * std::numbers::pi;
    const Delays& d = config_.delays;
    const double omega = two_pi * d.resonance_Hz;
    drive_ -= std::expm1(-two_pi * d.amplifier_bandwidth_Hz * dt_s) * (setpoint - drive_);
    velocity_ += dt_s * (omega * omega * (drive_ - position_) - 2.0 * d.damping_ratio * omega * velocity_);
    position_ += dt_s * velocity_;
    if (d.sensor_bandwidth_Hz > 0.0)
      sensed_ -= std::expm1(-two_pi * d.sensor_bandwidth_Hz * dt_s) * (position_ - sensed_);
  }

  LoopConfig config_;
  std::deque<double> late_ = std::deque<double>(8, 0.0);  ///< last setpoints, newest at the end
  double drive_ = 0.0, velocity_ = 0.0, position_ = 0.0, sensed_ = 0.0;
};

/// The largest error in the last tenth of the cycles after a step of the reference by 1.
inline double error_after(const LoopConfig& config, const PiGains& gains, int cycles) {
  FinePlant plant(config);
  Notch::State notch_state;
  const Notch::Coefficients notch =
      config.notch ? Notch::design(*config.notch, config.cycle_s) : Notch::Coefficients{};
  double filtered = 0.0, integral = 0.0, worst = 0.0;
  for (int n = 0; n < cycles; ++n) {
    const double error = 1.0 - plant.sample();
    filtered = config.measurement_filter_Hz > 0.0
                   ? low_pass(config.measurement_filter_Hz, filtered, error, config.cycle_s)
                   : error;
    integral += gains.ki_per_s * filtered * config.cycle_s;
    plant.step(Notch::step(notch, notch_state, gains.kp * filtered + integral));
    if (n >= cycles - cycles / 10) worst = std::max(worst, std::abs(error));
    if (!(std::abs(error) < 1e12)) return 1e12;
  }
  return worst;
}

}  // namespace hystcan::controller::simulated
