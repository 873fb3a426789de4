// Creep behind a hysteresis: the part of the output that comes late, logarithmic in time.
//
//   h          output of the hysteresis, at once
//   x          output of the actuator
//   tau_i      lags of the creep, from from_s on, two in each decade, i = 1 .. n
//   w          weight, the same for all: per_decade / 2
//
//   x = h + w sum_i (y_i - h),   y_i' = (h - y_i) / tau_i
//
// An output that is held long enough is h: the creep is what has not come yet. From rest at zero, a step of h
// gives
//
//   x(t) = h [1 - w sum_i e^{-t / tau_i}]
//
// which increases by 2 w h in each decade of time between the lags. y_i does not depend on h of the same
// moment, so that the inverse is exact:
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
    double per_decade = 0.0;  ///< 2 w, share of the output
    double from_s = 0.01;     ///< shortest lag
    double to_s = 3.0;        ///< longest lag, to the nearest half decade

    bool operator==(const Config&) const = default;
  };
  using State = std::vector<double>;  ///< y_i, output units

  /// Without creep: x = h.
  OutputCreep() = default;
  /// Throws std::invalid_argument if a number is not finite, if not 0 < from_s <= to_s, if there are more
  /// than most_lags, or if less than half of the output comes at once (n w > 1/2).
  explicit OutputCreep(const Config& config);
  explicit OutputCreep(const std::optional<Config>& config)
      : OutputCreep(config ? OutputCreep(*config) : OutputCreep()) {}

  /// After h was held for a very long time.
  State settled(double h) const { return State(rates_per_s_.size(), h); }

  // A state belongs to the same Config. None of these allocates.
  void settle(State& state, double h) const { state.assign(rates_per_s_.size(), h); }
  double output(const State& state, double h) const;   ///< x
  double inverse(const State& state, double x) const;  ///< h
  /// Holds h for dt_s. An h that is not finite changes nothing.
  void advance(State& state, double h, double dt_s) const;

  std::size_t lags() const { return rates_per_s_.size(); }
  double at_once() const { return at_once_; }                              ///< 1 - n w
  double weight() const { return weight_; }                                ///< w
  const std::vector<double>& rates_per_s() const { return rates_per_s_; }  ///< 1 / tau_i
  /// Amplitude of x for a sine of h of amplitude 1.
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
/// The inverse gives h_n for x_n, before the row's h is known. Times increase; steps may differ. The first
/// row is settled, unless a state of earlier rows is given.
class HeldCreep {
 public:
  struct State {
    OutputCreep::State creep;
    double h = 0.0;                  ///< of the last row
    std::optional<double> time_s{};  ///< of the last row; none: the creep is that of the next row
  };

  explicit HeldCreep(OutputCreep creep, std::optional<State> start = {});

  // Each row calls hold_until(), then perhaps inverse(), then follow(). None of them allocates after the
  // first row.
  /// Holds h until the time of the row, which is later than that of the row before.
  void hold_until(double time_s);
  double inverse(double x) const;  ///< h
  /// The row has this h. Returns x.
  double follow(double h);

  /// None before the first row.
  const std::optional<State>& state() const { return state_; }
  const OutputCreep& creep() const { return creep_; }

 private:
  OutputCreep creep_;
  std::optional<State> state_;
  double now_s_ = 0.0;
};

}  // namespace hystcan::model
