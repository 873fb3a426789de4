// A model driven row by row, from a recorded input or, inverted, from a wanted output: the core of `hystcan
// simulate`.
#pragma once

#include <cstddef>

#include "model/hysteresis.h"

namespace hystcan::model {

/// Starts virgin at the lower threshold, so that the first row lies on f_0^A.
class Simulation {
 public:
  struct Row {
    double input = 0.0;   ///< as given to follow_input(); what the inverse found from follow_output()
    double output = 0.0;  ///< what the model gives at that input
  };
  struct Tally {
    std::size_t rows = 0;
    std::size_t saturated = 0;       ///< beyond the thresholds, taken at the threshold
    std::size_t not_increasing = 0;  ///< on a branch that is not increasing
  };

  explicit Simulation(const Hysteresis& model, std::size_t capacity = 4096);

  Row follow_input(double input);
  Row follow_output(double output);

  const Tally& tally() const { return tally_; }
  const HysteresisState& state() const { return state_; }

 private:
  void count(const Prediction& step);

  Hysteresis model_;
  HysteresisState state_;
  Tally tally_;
};

}  // namespace hystcan::model
