#include "model/linear_mapping.h"

#include <utility>

#include "model/fingerprint.h"
#include "model/memory_model_impl.h"
#include "model/validity.h"

namespace hystcan::model {

AffineMap::AffineMap(HysteresisParameters parameters) : parameters_(std::move(parameters)) {
  parameters_.k_ascending = parameters_.k_descending = 0.0;
  check_curves(parameters_);
  ascending_third_ = parameters_.ascending.third_derivative_bound();
  descending_third_ = parameters_.descending.third_derivative_bound();
}

std::uint64_t AffineMap::fingerprint() const {
  Fingerprint sum;
  sum.add(kind());
  add_curves(sum, parameters_);
  return sum.value();
}

Branch AffineMap::joined(Point start, Point target, Direction direction) const {
  const ReferenceCurve& reference = parameters_.curve(direction);
  const double start_value = reference.value(start.input);
  const double rise = reference.value(target.input) - start_value;
  const bool rises = sign(direction) * rise > 0.0;  // false if the loop is as small as rounding
  const double b = rises ? (target.level - start.level) / rise : 0.0;
  return {start.input, start.level, start.level - b * start_value, b, b > 0.0};
}

Branch AffineMap::threshold_branch(Direction direction) const {
  const Point low = parameters_.lower_point(), high = parameters_.upper_point();
  return direction == Direction::ascending ? joined(low, high, direction) : joined(high, low, direction);
}

Branch AffineMap::virgin_branch() const {
  const Point low = parameters_.lower_point();
  return {low.input, low.level, 0.0, 1.0, true};
}

Branch AffineMap::reversed(const HysteresisState& state) const {
  const Branch& travelled = state.branches.back();
  return joined({state.input, state.level}, {travelled.start_input, travelled.start_level},
                opposite(state.direction()));
}

double AffineMap::value(const Branch& branch, Direction direction, double input) const {
  return branch.offset + branch.coefficient * parameters_.curve(direction).value(input);
}

Jet AffineMap::jet(const Branch& branch, Direction direction, double input) const {
  const Jet reference = parameters_.curve(direction).jet(input);
  return {branch.offset + branch.coefficient * reference.value, branch.coefficient * reference.slope,
          branch.coefficient * reference.curvature};
}

template class MemoryModel<AffineMap>;

}  // namespace hystcan::model
