// Creep behind a hysteresis: the part of the output that arrives late, logarithmic in time.
//
//   h          output of the hysteresis
//   x          output of the actuator
//   tau_i      lags of the creep, from from_s on, two in each decade, i = 1 .. n
//   w          weight, the same for all lags: per_decade / 2
//
//   x = h + w sum_i (y_i - h),   y_i' = (h - y_i) / tau_i
//
// If the output is held long enough, x reaches h: creep is the part of h that has not arrived yet. From rest
// at zero, a step of h gives
//
//   x(t) = h [1 - w sum_i e^{-t / tau_i}]
//
// which increases by 2 w h in each decade of time between the lags. y_i(t) does not depend on h(t), so that
// the inverse is exact:
//
//   h = (x - w sum_i y_i) / (1 - n w)
//
// The step is exact for an h that is held during it.
#pragma once

#include <optional>
#include <vector>

namespace hystcan::model {

class OutputCreep {
 public:
  struct Config {
    double per_decade = 0.0;  ///< creep in each decade of time, as a share of the output: 2 w
    double from_s = 0.01;     ///< shortest lag
    double to_s = 3.0;        ///< longest lag, to the nearest half decade

    bool operator==(const Config&) const = default;
  };
  using State = std::vector<double>;  ///< y_i, output units

  /// Constructs an OutputCreep without creep: x = h.
  OutputCreep() = default;
  /// Throws std::invalid_argument if a number is not finite, if not 0 < from_s <= to_s, if there are more
  /// than most_lags lags, or if less than half of the output arrives immediately (n w > 1/2).
  explicit OutputCreep(const Config& config);
  explicit OutputCreep(const std::optional<Config>& config)
      : OutputCreep(config ? OutputCreep(*config) : OutputCreep()) {}

  /// Returns the state after the hysteresis has had the output h for a very long time.
  State settled(double h) const { return State(rates_per_s_.size(), h); }

  // A state must belong to the same Config. None of the following functions allocates.
  void settle(State& state, double h) const { state.assign(rates_per_s_.size(), h); }
  double output(const State& state, double h) const;   ///< returns x, the output of the actuator
  double inverse(const State& state, double x) const;  ///< returns h, the output of the hysteresis
  /// Advances the state by dt_s, in which the hysteresis has the output h. An h that is not finite leaves the
  /// state unchanged.
  void advance(State& state, double h, double dt_s) const;

  std::size_t lags() const { return rates_per_s_.size(); }
  double at_once() const { return at_once_; }                              ///< immediate share, 1 - n w
  double weight() const { return weight_; }                                ///< w of each lag
  const std::vector<double>& rates_per_s() const { return rates_per_s_; }  ///< 1 / tau_i
  /// Returns the amplitude of x for a sine of h with amplitude 1.
  double amplitude_at(double frequency_Hz) const;

  static constexpr std::size_t most_lags = 32;

 private:
  double late(const State& state) const;  // w sum_i y_i

  double weight_ = 0.0, at_once_ = 1.0;
  std::vector<double> rates_per_s_;  // 1 / tau_i
};

/// Creep behind a hysteresis whose input is held from each row until the next one:
///
///   h(t) = h_n   for t_n <= t < t_{n+1}
///   x_n  = h_n + w sum_i (y_i(t_n) - h_n)
///
/// inverse() returns h_n for x_n before h_n is known. Times must increase; steps may differ. The first row is
/// settled unless a state of earlier rows is given.
class HeldCreep {
 public:
  struct State {
    OutputCreep::State creep;
    double h = 0.0;                  ///< output of the hysteresis in the last row
    std::optional<double> time_s{};  ///< time of the last row; `nullopt`: `creep` belongs to the next row
  };

  explicit HeldCreep(OutputCreep creep, std::optional<State> start = {});

  // In each row, call hold_until(), then inverse() if needed, then follow(). None of them allocates after the
  // first row.
  /// Holds h until the time of the row, which must be later than the time of the row before.
  void hold_until(double time_s);
  double inverse(double x) const;  ///< returns the h that gives the output x in this row
  /// Sets h, the output of the hysteresis in this row. Returns x, the output of the actuator.
  double follow(double h);

  /// Returns the state after the last row; `nullopt` before the first row.
  const std::optional<State>& state() const { return state_; }
  const OutputCreep& creep() const { return creep_; }

 private:
  OutputCreep creep_;
  std::optional<State> state_;
  double now_s_ = 0.0;
};

}  // namespace hystcan::model
