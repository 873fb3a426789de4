// Creep: the slow drift that follows a change of the input. It is modelled as a sum of operators with a
// threshold:
//
//   y_i' = a_i max(u - y_i - r_i, min(u - y_i + r_i, 0)),    output = sum_i w_i y_i
//
//   u          input
//   y_i        memory of operator i, input units; y_i' is its derivative by time
//   r_i >= 0   threshold, input units
//   a_i > 0    rate, 1/s
//   w_i        weight, output units per input unit
//
// Each y_i follows the input u at its own rate and stops at the distance r_i from u. An operator with r_i = 0
// is a linear lag. Kuhnen uses one operator for each pair of threshold and rate; this class uses one list of
// operators. If the input is constant during a step of length dt, the step is exact:
//
//   y_i[n+1] = y_i[n] + (1 - e^{-a_i dt}) max(u - y_i[n] - r_i, min(u - y_i[n] + r_i, 0))
//
// H. Janocha, K. Kuhnen, "Real-time compensation of hysteresis and creep in piezoelectric actuators", Sensors
// and Actuators A 79, 2000.  K. Kuhnen, P. Krejci, "Compensation of complex hysteresis and creep effects in
// piezoelectrically actuated systems - a new Preisach modeling approach", IEEE Trans. Automatic Control
// 54(3), 2009.
#pragma once

#include <vector>

namespace hystcan::model {

/// Computes creep in steps of fixed length. The constructor computes all coefficients; a step does not
/// allocate. The State that a caller passes must have one value for each operator.
class Creep {
 public:
  struct Operator {
    double weight = 0.0;      ///< weight w, output units per input unit; may be negative
    double rate_per_s = 1.0;  ///< rate a: 1 / time constant, greater than 0
    double threshold = 0.0;   ///< distance r from the input at which the memory stops, input units; 0 or more
  };
  using Operators = std::vector<Operator>;
  using State = std::vector<double>;  ///< memory y_i of each operator, input units
  /// Returns the state after the input was constant for a very long time: the memory of each operator equals
  /// the input.
  static State settled(const Operators& operators, double input) { return State(operators.size(), input); }

  /// Throws std::invalid_argument if dt_s is not positive, or if an operator is not valid: its weight is not
  /// finite, its rate is not positive, or its threshold is negative. The message contains the index of the
  /// operator.
  Creep(Operators operators, double dt_s);
  /// Advances the state by one step of dt_s, during which the input is constant. Returns the creep after the
  /// step, in output units. If the input is not finite, the state does not change.
  double operator()(State& state, double input) const;
  /// Returns the creep: the sum of weight times memory over all operators.
  double output(const State& state) const;

 private:
  Operators operators_;
  // For each operator, 1 - e^{-rate dt}. In a step, the memory of the operator covers this part of its
  // distance from the input.
  std::vector<double> shares_;
};

/// Returns operators that approximate logarithmic creep: the output x at the time t after a step of the
/// input,
///
///   x(t) = x_0 [1 + gamma log10(t / from_s)]      for from_s <= t <= to_s
///
///   x_0      output at the time from_s
///   gamma    creep per decade of time, `per_decade`; 0.01 to 0.02 for piezo actuators
///
/// H. Jung, D.-G. Gweon, "Creep characteristics of piezoelectric actuators", Rev. Sci. Instrum. 71(4), 2000.
///
/// The logarithm has no beginning and no end in time. The approximation is a sum of linear operators
/// (threshold 0) of weight gamma / 2. There are two operators in each decade of time constants, from
/// 10^{-1/2} from_s to at least 10^2 to_s. With C(t) the creep after a unit step at rest, the approximation
/// has these properties:
///
///   - The slope dC / dlog10(t) is gamma, with an error of 0.6 % of gamma. The spacing of the operators
///     causes a ripple of 0.23 %. Near to_s, the slope is up to 0.5 % too small, because slower operators are
///     missing.
///   - C(t) - C(from_s) is gamma log10(t / from_s), with an error of 0.24 % of gamma.
///   - C(from_s) is 1.00 gamma. This creep before from_s is a part of x_0: x_0 is (1 + gamma) times the
///     response without creep, and gamma is a share of the response without creep.
///   - Before from_s, the creep begins at zero and is linear in time. After to_s, it becomes slower, but
///     still grows by another 2 to 2.5 gamma in total.
///   - The approximation is linear: the creep of successive steps adds up. Real creep has thresholds and adds
///     up only roughly.
///
/// Throws std::invalid_argument if gamma is not finite, or if 0 < from_s < to_s does not hold.
Creep::Operators logarithmic_creep(double per_decade, double from_s, double to_s);

}  // namespace hystcan::model
