// The memory-based framework (Bashash, Jalili 2006 to 2009).  When the path turns, the model remembers the
// turning point and starts a new branch. The new branch targets the last turning point before this one. When
// the path reaches the target, it continues on the branch that ended at the target: the path aligns with it.
// The Law defines the shape of a branch between its start and its target; everything else is common to all
// laws and is in this class.
//
// A step costs O(1), amortised: turning points are ordered in input and in level, a reversal pushes one
// branch, and reaching a target pops two.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "model/hysteresis_operator.h"
#include "model/memory.h"
#include "model/memory_text.h"
#include "model/root.h"

namespace hystcan::model {

/// The law of a model: the shape of its branches. Each branch is a function of the input that increases from
/// its start to its target.
template <class L>
concept BranchLaw = requires(const L& law, const Branch& branch, const HysteresisState& state,
                             Direction direction, double v) {
  // The type of the parameters from which a law is constructed.
  typename L::Parameters;
  { law.kind() } -> std::convertible_to<std::string_view>;  // the name in a model file
  { law.fingerprint() } -> std::same_as<std::uint64_t>;     // hash of all parameters
  { law.input_range() } -> std::convertible_to<Interval>;
  { law.symmetry() } -> std::same_as<Symmetry>;
  // The branch that rises from L_0, the lower end of the major loop, or falls from U_0, its upper end.
  { law.threshold_branch(direction) } -> std::same_as<Branch>;
  // The branch of an empty memory, with L_0 (the lower end of the major loop) as its start.
  { law.virgin_branch() } -> std::same_as<Branch>;
  { law.reversed(state) } -> std::same_as<Branch>;  // the branch that starts at the present point
  { law.value(branch, direction, v) } -> std::same_as<double>;
  { law.jet(branch, direction, v) } -> std::same_as<Jet>;
  // Upper bound of |d3f/dv3| on the branch; infinity if the slope has kinks.
  { law.third_derivative_bound(branch, direction) } -> std::same_as<double>;
};

/// Thrown if a memory cannot be restored. what() contains the reason with actual and expected values; `index`
/// is the turning point.
class MemoryError : public std::invalid_argument {
 public:
  MemoryError(std::size_t at, const std::string& what) : std::invalid_argument(what), index(at) {}
  std::size_t index;
};

/// A model whose output is the value of its present branch at the present input. This value is called the
/// level, because class Hysteresis maps the level of a butterfly to another output.
///
/// forward() and inverse() do not change the memory; advance() does. None of these allocates, and save() does
/// not either. A non-finite argument gives `finite = false`: forward() and inverse() return NaN; advance()
/// leaves the memory unchanged and returns the present output.
template <BranchLaw Law>
class MemoryModel {
 public:
  using State = HysteresisState;
  static constexpr std::size_t default_capacity = 256;

  explicit MemoryModel(Law law);
  explicit MemoryModel(typename Law::Parameters parameters) : MemoryModel(Law(std::move(parameters))) {}

  const auto& parameters() const { return law_.parameters(); }

  const Interval& input_range() const { return law_.input_range(); }
  Symmetry symmetry() const { return law_.symmetry(); }
  /// Returns the outputs between L_0 and U_0, the two ends of the major loop. Every memory can reach these
  /// outputs.
  Interval output_range() const { return {lower_.start_level, upper_.start_level}; }
  /// Returns the outputs that this state can reach: for each of them, inverse() returns an input that is not
  /// saturated.
  Interval reachable(const State& state) const;
  /// Returns the outputs that this state can reach with an input in `inputs` (>= 0 if symmetry is even).
  Interval reachable(const State& state, Interval inputs) const;

  /// Returns an empty memory, at `input` on the initial ascending curve. `capacity`: maximum number of stored
  /// branches, at least 4. Throws std::invalid_argument if `input` is outside the thresholds or the capacity
  /// is too small.
  State virgin(double input, std::size_t capacity = default_capacity) const;
  /// Returns the memory at a threshold point, where all earlier turning points are wiped out.
  State at_lower_threshold(std::size_t capacity = default_capacity) const;
  State at_upper_threshold(std::size_t capacity = default_capacity) const;
  /// Returns the memory with these turning points. If `points` contains levels (values of the branches at the
  /// turning points), they are restored to the bit. Throws MemoryError if the points are not nested, are
  /// outside the thresholds, are too many for `capacity`, or if a level differs from the level of this model
  /// by more than 1e-9 of the distance between the levels of the two thresholds.
  State remembering(const TurningPoints& points, std::size_t capacity = default_capacity) const;

  /// Returns the output that `input` would give.
  Prediction forward(const State& state, double input) const;
  /// Returns the input (>= 0 if symmetry is even) that would give `output`:
  ///   forward(state, inverse(state, x).value).value = x
  /// If `output` is out of reach, returns the input of the nearest reachable output.
  FoundInput inverse(const State& state, double output) const;
  /// Applies `input`: remembers turning points and wipes out closed loops.
  Prediction advance(State& state, double input) const;
  /// Applies the result of inverse() for this state. If inverse() has already computed the value of the
  /// branch at the found input, this value is used and not computed again.
  Prediction advance(State& state, const FoundInput& found) const;

  /// Returns the memory as a TOML table (model/memory_text.h); empty if the buffer is too small. A buffer of
  /// saved_size(capacity) is always large enough.
  std::string_view save(const State& state, std::span<char> buffer) const;
  static constexpr std::size_t saved_size(std::size_t capacity = default_capacity) {
    return 400 + 2 * MemoryText::number_size * (capacity + 2);
  }
  std::uint64_t fingerprint() const { return law_.fingerprint(); }
  static constexpr std::string_view kind() { return Law::kind(); }

 private:
  struct Segment;

  double folded(double input) const { return symmetry() == Symmetry::even ? std::abs(input) : input; }
  static void put(State& state, double input, double level);
  State from(Origin origin, std::size_t capacity) const;
  const Branch& target(const State& state, std::size_t index) const;
  void go_to(State& state, std::size_t index, const char* what, double input) const;
  void restore_level(State& state, std::size_t index, double level) const;
  template <double Branch::*axis>
  Segment locate(const State& state, double from, double to) const;
  template <double Branch::*axis>
  bool stays_on_branch(const State& state, double from, double to) const;
  Prediction on_branch(const State& state, double input) const;
  Prediction advance_past(State& state, double input) const;
  double follow(const Segment& segment, double input) const;
  bool is_rounding(double levels) const { return std::abs(levels) <= 4.0 * rounding_; }
  FoundInput solve(const State& state, const Branch& branch, Direction direction, double begin,
                   const Branch& end, double level) const;

  Law law_;
  Branch lower_, upper_;  // the branches that start at L_0 and at U_0
  double rounding_;       // levels that differ by at most this value count as equal in inverse()
};

}  // namespace hystcan::model
