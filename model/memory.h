// The memory of an actuator: its turning points, and the branches that ended at them.
//
// Branches b_0, b_1, ... alternate in direction; the path is on the last one.  b_0 starts at a threshold
// point and targets the opposite one.  b_j targets the start of b_{j-1}. b_{j-2} has the same direction as
// b_j and ended at this target; it is called the branch `below` b_j.  When the path reaches the target of
// b_m, b_m and b_{m-1} are popped (wiping out), and the path continues on b_{m-2} (curve alignment).  At a
// threshold only one branch is left; it starts at that threshold.
//
// A branch is a function from the input to the level. The level is the output of the model, except in a
// butterfly: there the output is a map of the level (model/output_map.h). Memory, laws and memory files
// contain only the level.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "model/root.h"

namespace hystcan::model {

enum class Symmetry { none, even };  ///< even: an input and its negative give the same output, x(v) = x(-v)
constexpr auto words(Symmetry) { return std::to_array<std::string_view>({"none", "even"}); }

enum class Direction : int { ascending = 1, descending = -1 };

constexpr double sign(Direction direction) { return direction == Direction::ascending ? 1.0 : -1.0; }

constexpr Direction opposite(Direction direction) {
  return direction == Direction::ascending ? Direction::descending : Direction::ascending;
}

/// One remembered branch: the turning point where it started, and two numbers that describe its shape. Each
/// model defines the meaning of these two numbers.
struct Branch {
  double start_input = 0.0;
  double start_level = 0.0;
  double offset = 0.0;
  double coefficient = 0.0;
  bool increasing = true;  ///< false: the model's law has found that the branch does not increase
};

/// A stack of branches that allocates only at construction. A copy keeps the capacity.
class BranchStack {
 public:
  explicit BranchStack(std::size_t capacity = 0) : slots_(capacity) {}

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return slots_.size(); }
  bool full() const { return size_ == slots_.size(); }
  const Branch& operator[](std::size_t i) const { return slots_[i]; }
  const Branch& back() const { return slots_[size_ - 1]; }
  const Branch* begin() const { return slots_.data(); }
  const Branch* end() const { return slots_.data() + size_; }
  void push(const Branch& branch) { slots_[size_++] = branch; }  ///< must not be called when full()
  /// Removes the last branches until `count` are left.
  void keep(std::size_t count) { size_ = count; }

 private:
  std::vector<Branch> slots_;
  std::size_t size_ = 0;
};

/// Start of b_0, the outermost branch. For `virgin`, b_0 is the ascending reference curve f_0^A itself.
/// Falling branches from this curve target L_0, the point of the descending curve at the lower threshold.
/// Therefore b_0 has the start_input and start_level of L_0, although L_0 is not on f_0^A.
enum class Origin { virgin, lower_threshold, upper_threshold };
constexpr auto words(Origin) {
  return std::to_array<std::string_view>({"virgin", "lower-threshold", "upper-threshold"});
}

struct Point {
  double input = 0.0;
  double level = 0.0;
};

/// The whole memory of the actuator.
///
/// When the memory is full, a reversal adds no branch. Instead, the path moves backwards on the innermost
/// branch. At the start of this branch, the path continues on the branch before the innermost one, which
/// ended at this point. The new turning point is thus merged with the innermost one. The path stays
/// continuous and increasing; only the loop that would have opened inside the innermost one is lost. `merged`
/// counts the steps taken in this way.
struct HysteresisState {
  BranchStack branches;  ///< the outermost branch first; the capacity is fixed at construction
  Origin origin = Origin::virgin;
  double input = 0.0;   ///< present input v; its magnitude |v| if symmetry is even
  double level = 0.0;   ///< present value of the branch: in a butterfly, the input of the output map
  double output = 0.0;  ///< present output: `level`; in a butterfly, g(level) with the output map g
  std::size_t merged = 0;
  /// Value and derivatives of the branch at the input that the last inverse evaluated. The next inverse
  /// starts its search there.
  Expansion near{};

  std::size_t depth() const { return branches.size(); }
  Direction direction() const { return direction(depth() - 1); }
  Direction direction(std::size_t index) const {
    return (index % 2 == 0) == (origin != Origin::upper_threshold) ? Direction::ascending
                                                                   : Direction::descending;
  }
};

/// A memory as a list of turning points, outermost first. A memory file contains the same fields. The list
/// does not contain the threshold point at which the outermost branch starts; `origin` contains this
/// information. Each turning point is strictly between the two points before it. The two threshold points
/// count as the points before the first one.
struct TurningPoints {
  Origin origin = Origin::virgin;
  std::vector<double> inputs;  ///< inputs of the turning points
  /// Levels of the turning points: values of the branch, in a butterfly before the output map. If empty, the
  /// model computes the levels.
  std::vector<double> levels;
  double input = 0.0;  ///< present input, between the last turning point and the target of the last branch
  std::optional<double> level;
  std::size_t merged = 0;
};

}  // namespace hystcan::model
