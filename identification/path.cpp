#include "identification/path.h"

#include <algorithm>
#include <utility>

#include "model/memory_model.h"
#include "model/memory_model_impl.h"

namespace hystcan::identification {
namespace {

// A branch law (model/memory_model.h) whose output equals its input. With this law, a MemoryModel only finds
// the branches and turning points of a sequence of inputs.
class InputLaw {
 public:
  using Parameters = model::Interval;
  explicit InputLaw(model::Interval range) : range_(range) {}
  static constexpr std::string_view kind() { return "path"; }
  static std::uint64_t fingerprint() { return 0; }
  const model::Interval& input_range() const { return range_; }
  static model::Symmetry symmetry() { return model::Symmetry::none; }
  model::Branch threshold_branch(model::Direction direction) const {
    return from(direction == model::Direction::ascending ? range_.lo : range_.hi);
  }
  model::Branch virgin_branch() const { return from(range_.lo); }
  static model::Branch reversed(const model::HysteresisState& state) { return from(state.input); }
  static double value(const model::Branch&, model::Direction, double v) { return v; }
  static model::Jet jet(const model::Branch&, model::Direction, double v) { return {v, 1.0, 0.0}; }
  static double third_derivative_bound(const model::Branch&, model::Direction) { return 0.0; }

 private:
  static model::Branch from(double v) { return {v, v, 0.0, 0.0, true}; }
  model::Interval range_;
};

// Applies inputs to a memory one by one. Gives a number to each branch when it starts, and stores the branch
// under this number.
class Tracer {
 public:
  /// `inputs`: expected number of inputs.
  Tracer(model::Interval thresholds, model::Origin origin, std::size_t inputs)
      : memory_(InputLaw(thresholds)), state_(start(origin, std::min(inputs + 4, most_branches))) {
    begin_at_threshold();
  }

  void advance(double input) {
    const std::size_t depth = state_.depth();
    const double before = state_.input;
    memory_.advance(state_, input);
    if (state_.input != before && is_at_threshold())
      begin_at_threshold();
    else if (state_.depth() > depth)
      begin_reversed();
    else
      numbers_.resize(state_.depth());
  }

  std::size_t branch() const { return numbers_.back(); }
  std::vector<PathBranch> take() { return std::move(branches_); }

 private:
  static constexpr std::size_t most_branches = 4096;

  model::HysteresisState start(model::Origin origin, std::size_t capacity) const {
    if (origin == model::Origin::virgin) return memory_.virgin(memory_.input_range().lo, capacity);
    return origin == model::Origin::lower_threshold ? memory_.at_lower_threshold(capacity)
                                                    : memory_.at_upper_threshold(capacity);
  }
  bool is_at_threshold() const {
    return state_.depth() == 1 && state_.input == state_.branches.back().start_input;
  }
  void begin_at_threshold() {
    const model::Interval& range = memory_.input_range();
    const bool up = state_.direction() == model::Direction::ascending;
    PathBranch branch;
    branch.direction = state_.direction();
    branch.start = up ? range.lo : range.hi;
    branch.target = up ? range.hi : range.lo;
    branch.virgin = state_.origin == model::Origin::virgin;
    numbers_.assign(1, branches_.size());
    branches_.push_back(branch);
  }
  void begin_reversed() {
    PathBranch branch;
    branch.direction = state_.direction();
    branch.start = state_.branches.back().start_input;
    branch.target = branches_[numbers_.back()].start;
    branch.parent = numbers_.back();
    if (numbers_.size() > 1) branch.below = numbers_[numbers_.size() - 2];
    numbers_.push_back(branches_.size());
    branches_.push_back(branch);
  }

  model::MemoryModel<InputLaw> memory_;
  model::HysteresisState state_;
  std::vector<std::size_t> numbers_;  // numbers of the branches that are in the memory now
  std::vector<PathBranch> branches_;
};

}  // namespace

Path trace(model::Interval thresholds, model::Origin origin, std::span<const double> prehistory,
           std::span<const double> inputs) {
  Tracer tracer(thresholds, origin, prehistory.size() + inputs.size());
  for (const double input : prehistory) tracer.advance(input);
  Path path;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    tracer.advance(inputs[i]);
    if (path.runs.empty() || path.runs.back().branch != tracer.branch())
      path.runs.push_back({tracer.branch(), i, i});
    path.runs.back().end = i + 1;
  }
  path.branches = tracer.take();
  return path;
}

}  // namespace hystcan::identification
