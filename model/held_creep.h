// Creep behind a hysteresis whose input is held from each row until the next one (model/output_creep.h).
//
//   h(t) = h_n   for t_n <= t < t_{n+1}
//   x_n  = h_n + w sum_i (y_i(t_n) - h_n)
//
// The inverse gives h_n for x_n, before the row's h is known. Times increase; steps may differ. The first row is settled,
// unless a state of earlier rows is given.
#pragma once

#include <optional>

#include "model/output_creep.h"

namespace hystcan::model {

class HeldCreep {
 public:
  struct State {
    OutputCreep::State creep;
    double h = 0.0;                  ///< of the last row
    std::optional<double> time_s{};  ///< of the last row; none: the creep is that of the next row
  };

  explicit HeldCreep(OutputCreep creep, std::optional<State> start = {});

  // Each row calls hold_until(), then perhaps inverse(), then follow(). None of them allocates after the first row.
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
