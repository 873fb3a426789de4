#include "identification/initial_memory.h"

#include <algorithm>
#include <cmath>

namespace hystcan::identification {
namespace {

constexpr int loops = 16;

}  // namespace

model::Origin InitialMemory::origin() const {
  switch (kind) {
    case Kind::virgin:
      return model::Origin::virgin;
    case Kind::from_upper:
      return model::Origin::upper_threshold;
    case Kind::from_lower:
    case Kind::nested:
      break;
  }
  return model::Origin::lower_threshold;
}

std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first) {
  std::vector<double> inputs;
  if (memory.kind != InitialMemory::Kind::nested) return inputs;
  const double up = std::exp(memory.bias), down = std::exp(-memory.bias);
  for (int j = 1; j <= loops; ++j) {
    const double left = 1.0 - j / (loops + 1.0);
    inputs.push_back(first + (thresholds.hi - first) * std::pow(left, up));
    inputs.push_back(first - (first - thresholds.lo) * std::pow(left, down));
  }
  return inputs;
}

model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first) {
  const model::Interval& range = model.input_range();
  const double travelled = model.symmetry() == model::Symmetry::even ? std::abs(first) : first;
  const double start = std::clamp(travelled, range.lo, range.hi);
  if (memory.kind == InitialMemory::Kind::virgin) return model.virgin(start);
  model::HysteresisState state = memory.kind == InitialMemory::Kind::from_upper ? model.at_upper_threshold()
                                                                                : model.at_lower_threshold();
  for (const double input : prehistory(memory, range, start)) model.advance(state, input);
  model.advance(state, start);
  return state;
}

}  // namespace hystcan::identification
