// The memory of an actuator at the beginning of a dataset. It is unknown and is estimated from the dataset.
//
// The dataset shows only how the earlier turning points lay around the first input v_0. They are modelled as
// a decaying oscillation of N nested loops between the thresholds, with one parameter, the bias b:
//
//   u_j = v_0 + (v_hi - v_0) (1 - j / (N + 1))^(e^b)
//   l_j = v_0 - (v_0 - v_lo) (1 - j / (N + 1))^(e^-b)
//
//   b = 0               demagnetised
//   b ->  infinity      arrived directly from the lower threshold
//   b -> -infinity      arrived directly from the upper threshold
//
// In the Preisach plane the u_j, l_j are the staircase between the two half planes.
#pragma once

#include <span>
#include <vector>

#include "model/hysteresis.h"

namespace hystcan::identification {

struct InitialMemory {
  enum class Kind { virgin, from_lower, from_upper, nested };
  Kind kind = Kind::virgin;
  double bias = 0.0;  ///< b, for `nested` only

  model::Origin origin() const;
};

/// Inputs that lead from the origin to `first`, without `first`; empty if the memory is virgin.
std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first);

/// The same memory as a state of the model, at the input `first`.
model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first);

}  // namespace hystcan::identification
