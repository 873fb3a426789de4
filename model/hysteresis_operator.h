// The common interface of all hysteresis models, for simulation, comparison and benchmarks.
//
// A model holds its parameters, which are checked once. The memory is in the State that the caller passes.
// forward() and inverse() do not change the memory; advance() does. None of the three allocates.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "model/reference_curve.h"

namespace hystcan::model {

/// A limited value is not an error: the result contains the value and the reason.
struct Prediction {
  double value = 0.0;      ///< output of forward() and advance(), input of inverse()
  bool saturated = false;  ///< the request was out of reach; the nearest reachable value was used
  bool increasing = true;  ///< false: the branch in use does not increase; its inverse is not reliable
  bool finite = true;      ///< false: the request was not a finite number; the memory was not changed
};

template <class M>
concept HysteresisOperator = requires(const M& model, const typename M::State& state,
                                      typename M::State& moved, double number, std::span<char> text) {
  { model.kind() } -> std::convertible_to<std::string_view>;      // as in a model file
  { model.fingerprint() } -> std::same_as<std::uint64_t>;         // of all parameters
  { model.input_range() } -> std::convertible_to<Interval>;       // thresholds, input units
  { model.virgin(number) } -> std::same_as<typename M::State>;    // empty memory, at this input
  { model.reachable(state) } -> std::same_as<Interval>;           // outputs within reach from here
  { model.forward(state, number) } -> std::same_as<Prediction>;   // the output that this input would give
  { model.inverse(state, number) } -> std::same_as<Prediction>;   // the input that would give this output
  { model.advance(moved, number) } -> std::same_as<Prediction>;   // applies this input
  { model.save(state, text) } -> std::same_as<std::string_view>;  // memory as TOML; empty: text too small
  { moved.input } -> std::same_as<double&>;
  { moved.output } -> std::same_as<double&>;
};

struct Row {
  double input = 0.0;   ///< the argument of follow_input(), or the input that follow_output() found
  double output = 0.0;  ///< the model's output at that input
};

struct Tally {
  std::size_t rows = 0;
  std::size_t saturated = 0;       ///< out of reach, replaced by the edge
  std::size_t not_increasing = 0;  ///< on a branch that does not increase

  void count(const Prediction& step) {
    ++rows;
    if (step.saturated) ++saturated;
    if (!step.increasing) ++not_increasing;
  }
};

/// Runs a model row by row, from a recorded input or (inverted) from a wanted output: the core of
/// `hystcan simulate`.
template <HysteresisOperator Model>
class Simulation {
 public:
  using State = typename Model::State;

  /// `drive_sign`: sign of the inputs that follow_output() finds; -1 makes sense only if symmetry is even.
  Simulation(Model model, State start, double drive_sign = 1.0)
      : model_(std::move(model)), state_(std::move(start)), drive_sign_(drive_sign) {}

  Row follow_input(double input) {
    tally_.count(model_.advance(state_, input));
    return {input, state_.output};
  }
  Row follow_output(double output) {
    const Prediction drive = model_.inverse(state_, output);
    model_.advance(state_, drive.value);
    tally_.count(drive);
    return {drive_sign_ * state_.input, state_.output};
  }

  const Tally& tally() const { return tally_; }
  const Model& model() const { return model_; }
  const State& state() const { return state_; }

 private:
  Model model_;
  State state_;
  double drive_sign_;
  Tally tally_;
};

}  // namespace hystcan::model
