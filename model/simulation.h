// Runs a model row by row, from a recorded input or (inverted) from a wanted output: the core of
// `hystcan simulate`.
#pragma once

#include <cstddef>
#include <utility>

#include "model/hysteresis_operator.h"

namespace hystcan::model {

struct Row {
  double input = 0.0;   ///< the argument of follow_input(), or the input that follow_output() found
  double output = 0.0;  ///< the model's output at that input
};

struct Tally {
  std::size_t rows = 0;
  std::size_t saturated = 0;       ///< out of reach, replaced by the edge
  std::size_t not_increasing = 0;  ///< on a branch that does not increase
};

template <HysteresisOperator Model>
class Simulation {
 public:
  using State = typename Model::State;

  /// `drive_sign`: sign of the inputs that follow_output() finds; -1 makes sense only if symmetry is even.
  Simulation(Model model, State start, double drive_sign = 1.0)
      : model_(std::move(model)), state_(std::move(start)), drive_sign_(drive_sign) {}

  Row follow_input(double input) {
    count(model_.advance(state_, input));
    return {input, state_.output};
  }
  Row follow_output(double output) {
    const Prediction drive = model_.inverse(state_, output);
    model_.advance(state_, drive.value);
    count(drive);
    return {drive_sign_ * state_.input, state_.output};
  }

  const Tally& tally() const { return tally_; }
  const Model& model() const { return model_; }
  const State& state() const { return state_; }

 private:
  void count(const Prediction& step) {
    ++tally_.rows;
    if (step.saturated) ++tally_.saturated;
    if (!step.increasing) ++tally_.not_increasing;
  }

  Model model_;
  State state_;
  double drive_sign_;
  Tally tally_;
};

}  // namespace hystcan::model
