// Creep behind a hysteresis: a part of the output arrives late, logarithmic in time.
//
//   h       output of the hysteresis
//   x       output of the actuator
//   n       number of lags
//   tau_i   time constant of lag i, two in each decade from `from_s` on, i = 1 .. n
//   y_i     output of lag i
//   w       weight of each lag, per_decade / 2
//
//   x = h + w sum_i (y_i - h),   y_i' = (h - y_i) / tau_i
//
// If the hysteresis keeps its output h long enough, x reaches h: the creep is the part of h that has not
// arrived yet. After a step from rest at zero to h,
//
//   x(t) = h [1 - w sum_i e^{-t / tau_i}]
//
// This response grows by 2 w h in each decade of time between the shortest and the longest lag. The lags y_i
// do not depend on the present h. The inverse is therefore exact:
//
//   h = (x - w sum_i y_i) / (1 - n w)
//
// A step in time is exact if h is constant during the step.
#pragma once

#include <optional>
#include <vector>

namespace hystcan::model {

class OutputCreep {
 public:
  struct Config {
    double per_decade = 0.0;  ///< part of the output that arrives in each decade of time
    double from_s = 0.01;     ///< time constant of the shortest lag
    double to_s = 3.0;        ///< time constant of the longest lag, rounded to half a decade

    bool operator==(const Config&) const = default;
  };
  using State = std::vector<double>;  ///< output of each lag, output units

  /// Constructs an object without creep: the output of the actuator equals the output of the hysteresis.
  OutputCreep() = default;
  /// Throws std::invalid_argument if a number is not finite, if 0 < from_s <= to_s does not hold, if there
  /// would be more than most_lags lags, or if all lags together delay more than half of the output.
  explicit OutputCreep(const Config& config);
  explicit OutputCreep(const std::optional<Config>& config)
      : OutputCreep(config ? OutputCreep(*config) : OutputCreep()) {}

  /// Returns the state after the hysteresis has had the constant output h for a very long time.
  State settled(double h) const { return State(rates_per_s_.size(), h); }

  // A state belongs to one Config and must not be used with another. None of the following functions
  // allocates.
  void settle(State& state, double h) const { state.assign(rates_per_s_.size(), h); }
  /// Returns the output of the actuator for the output h of the hysteresis.
  double output(const State& state, double h) const;
  /// Returns the output of the hysteresis that gives the output x of the actuator.
  double inverse(const State& state, double x) const;
  /// Advances the state by dt_s. During this time, the output of the hysteresis is h. If h is not finite, the
  /// state does not change.
  void advance(State& state, double h, double dt_s) const;

  std::size_t lags() const { return rates_per_s_.size(); }
  double at_once() const { return at_once_; }  ///< share of the output that arrives immediately
  double weight() const { return weight_; }    ///< weight of each lag
  const std::vector<double>& rates_per_s() const { return rates_per_s_; }  ///< 1 / time constant of each lag
  /// Returns the amplitude of the actuator's output if the output of the hysteresis is a sine with amplitude
  /// 1.
  double amplitude_at(double frequency_Hz) const;

  static constexpr std::size_t most_lags = 32;

 private:
  // Returns the part of the output that comes from the lags: the sum of their outputs times their weight.
  double late(const State& state) const;

  double weight_ = 0.0, at_once_ = 1.0;
  std::vector<double> rates_per_s_;  // 1 / time constant of each lag
};

/// Creep for data that arrive row by row. Row n has the time t_n, the output h_n of the hysteresis and the
/// output x_n of the actuator. The hysteresis keeps its output until the next row:
///
///   h(t) = h_n   for t_n <= t < t_{n+1}
///   x_n  = h_n + w sum_i (y_i(t_n) - h_n)        y_i, w: outputs and weight of the lags, see OutputCreep
///
/// inverse() computes h_n from a wanted x_n; follow() then sets h_n. The times of the rows must increase;
/// the time between two rows may vary. Before the first row, the creep is settled; if a state is given, the
/// creep continues from this state.
class HeldCreep {
 public:
  struct State {
    OutputCreep::State creep;
    double h = 0.0;  ///< output h of the hysteresis in the last data row, output units
    /// Time of the last data row. `nullopt`: `creep` is already the state at the time of the next row, so
    /// that the first call of hold_until() must not advance it.
    std::optional<double> time_s{};
  };

  explicit HeldCreep(OutputCreep creep, std::optional<State> start = {});

  // For each data row, call hold_until(), then inverse() if needed, then follow(). After the first row, none
  // of these functions allocates.
  /// Begins the data row with the time `time_s`, which must be later than the previous row. Advances the lags
  /// of the creep to this time; in between, the hysteresis keeps its output of the previous row.
  void hold_until(double time_s);
  /// Returns the output of the hysteresis with which the actuator has the output x at the time of
  /// hold_until().
  double inverse(double x) const;
  /// Sets the output h of the hysteresis at the time of hold_until(). Returns the actuator's output at this
  /// time.
  double follow(double h);

  /// Returns the state after the last data row; `nullopt` before the first row.
  const std::optional<State>& state() const { return state_; }
  const OutputCreep& creep() const { return creep_; }

 private:
  OutputCreep creep_;
  std::optional<State> state_;
  double now_s_ = 0.0;
};

}  // namespace hystcan::model
