// What an actuator remembers when a dataset begins: unknown, and estimated from the dataset.
//
// All that the dataset can tell is how the turning points of before lay around the first input v_0. They are
// taken as a decaying oscillation of N nested loops between the thresholds, with one number, the bias b:
//
//   u_j = v_0 + (v_hi - v_0) (1 - j / (N + 1))^(e^b),    l_j = v_0 - (v_0 - v_lo) (1 - j / (N + 1))^(e^-b)
//
// b = 0: demagnetised. b -> infinity: come straight from the lower threshold, b -> -infinity: from the upper
// one. In the Preisach plane the u_j, l_j are the staircase between the two half planes.
#pragma once

#include <span>
#include <vector>

#include "model/hysteresis.h"

namespace hystcan::identification {

struct InitialMemory {
  enum class Kind { virgin, from_lower, from_upper, nested };
  Kind kind = Kind::virgin;
  double bias = 0.0;  ///< b, of `nested`

  model::Origin origin() const;
};

/// Inputs that lead from the origin to `first`, `first` not included; none where it is virgin.
std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first);

/// The same memory in a model's own state, at the input `first`.
model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first);

}  // namespace hystcan::identification
