// The smart material of an actuator: a hysteresis model of any kind, and its memory.
//
//   x_h = H[v](t)
//
// The model is rate-independent: only the sequence of the values of v matters. Every drive is reached from
// the last one without a turning point in between. Where the symmetry is even (magnetostriction,
// x(v) = x(-v)), a drive that changes its sign passes through zero.
#pragma once

#include <cstddef>
#include <variant>

#include "model/any_model.h"

namespace hystcan::twin {

class Material {
 public:
  /// Starts on its virgin curve at `drive`. `branches`: capacity of the memory, where the model remembers
  /// branches. Throws std::invalid_argument where the model is invalid or does not reach `drive`.
  Material(const model::AnyParameters& parameters, double drive, std::size_t branches);

  /// Goes to `drive`, in drive units, limited to the thresholds. Returns the output, um.
  double go_to(double drive);
  /// The output that go_to(drive) would return. Changes no memory, except by a zero passed on the way.
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
