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

#include "model/reference_curve.h"
#include "model/root.h"

namespace hystcan::model {

/// Returns true if an input v and its negative give the same output, x(v) = x(-v).
template <class Model>
bool is_even(const Model& model) {
  if constexpr (requires { model.symmetry(); })
    return model.symmetry() == decltype(model.symmetry())::even;
  else
    return false;
}

/// Result of forward() and advance(). A limited value is not an error: the result contains the value and the
/// reason.
struct Prediction {
  double value = 0.0;      ///< output; in a FoundInput, the input
  bool saturated = false;  ///< the argument was out of reach; the nearest reachable value was used
  bool increasing = true;  ///< false: the branch in use does not increase; its inverse is not reliable
  bool finite = true;      ///< false: the argument was not a finite number; the memory was not changed
};

/// Result of inverse(): `value` is an input. advance() with this result usually need not evaluate the branch
/// again.
struct FoundInput : Prediction {
  /// Value and derivatives of the branch at the last input that inverse() evaluated. The slope is 0 if
  /// inverse() evaluated no input.
  Expansion near{};
  /// True if near(value) equals the wanted value of the branch to rounding. advance() then uses near(value)
  /// and does not evaluate the branch again.
  bool is_met = false;
};

template <class M>
concept HysteresisOperator = requires(const M& model, const typename M::State& state,
                                      typename M::State& moved, double number, std::span<char> text) {
  { model.kind() } -> std::convertible_to<std::string_view>;          // the name in a model file
  { model.fingerprint() } -> std::same_as<std::uint64_t>;             // hash of all parameters
  { model.input_range() } -> std::convertible_to<Interval>;           // thresholds, input units
  { model.virgin(number) } -> std::same_as<typename M::State>;        // empty memory at this input
  { model.reachable(state) } -> std::same_as<Interval>;               // outputs that this state can reach
  { model.forward(state, number) } -> std::same_as<Prediction>;       // the output that this input would give
  { model.inverse(state, number) } -> std::derived_from<Prediction>;  // the input that would give this output
  { model.advance(moved, number) } -> std::same_as<Prediction>;       // applies this input
  { model.advance(moved, model.inverse(state, number)) } -> std::same_as<Prediction>;
  { model.save(state, text) } -> std::same_as<std::string_view>;  // memory as TOML; empty: text too small
  { moved.input } -> std::same_as<double&>;
  { moved.output } -> std::same_as<double&>;
};

struct Tally {
  std::size_t rows = 0;
  /// Number of rows whose input or output was out of reach and was replaced by the nearest reachable value.
  std::size_t saturated = 0;
  /// Number of rows in which the branch in use does not increase.
  std::size_t not_increasing = 0;

  void count(const Prediction& step) {
    ++rows;
    if (step.saturated) ++saturated;
    if (!step.increasing) ++not_increasing;
  }
  Tally& operator+=(const Tally& other) {
    rows += other.rows;
    saturated += other.saturated;
    not_increasing += other.not_increasing;
    return *this;
  }
};

}  // namespace hystcan::model
