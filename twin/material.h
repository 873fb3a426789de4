// The smart material of an actuator: a hysteresis model of any kind, and what it remembers.
//
//   x_h = H[v](t)
//
// Rate-independent, so that only the order matters in which v goes through its values: every drive is reached
// from the one before without turning on the way.  Where the symmetry is even (magnetostriction, x(v) =
// x(-v)) a drive that changes its sign passes through zero.
#pragma once

#include <cstddef>
#include <variant>

#include "model/any_model.h"

namespace hystcan::twin {

class Material {
 public:
  /// On its virgin curve at `drive`. `branches`: how many it can remember, where it remembers branches.
  /// Throws std::invalid_argument where the model is not a valid one, or does not reach `drive`.
  Material(const model::AnyParameters& parameters, double drive, std::size_t branches);

  /// Goes to `drive`, in drive units; beyond the thresholds it is at them. Returns the output, um.
  double go_to(double drive);
  /// The output that go_to(drive) would give: nothing is remembered but a zero passed on the way.
  double look_at(double drive);

 private:
  template <class Model>
  struct Kind {
    Model model;
    typename Model::State state;
  };
  template <class Model>
  static Kind<Model> virgin(Model model, double drive, std::size_t branches);
  void pass_zero(double drive);

  std::variant<Kind<model::Hysteresis>, Kind<model::LinearMapping>, Kind<model::PrandtlIshlinskii>,
               Kind<model::Preisach>>
      kind_;
  bool even_ = false;
  double drive_;
};

}  // namespace hystcan::twin
