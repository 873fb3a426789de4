// Creep: the slow drift that follows a change of input, as a sum of threshold-discrete operators.
//
//   y_i' = a_i max(u - y_i - r_i, min(u - y_i + r_i, 0)),    output = sum_i w_i y_i
//
//   u          input
//   y_i        memory of operator i, input units
//   r_i >= 0   threshold, input units
//   a_i > 0    rate, 1/s
//   w_i        weight, output units per input unit
//
// Each y_i follows u at its own rate and stops at a distance r_i from u. r_i = 0 gives the linear lag. Kuhnen
// uses one operator for each pair of threshold and rate; this class uses one list of operators.
// The step is exact for an input that is held during the step:
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

/// Creep with steps of fixed length. The coefficients are computed once. A state must have one value for each
/// operator. A step does not allocate.
class Creep {
 public:
  struct Operator {
    double weight = 0.0;      ///< w, output units per input unit, of either sign
    double rate_per_s = 1.0;  ///< a > 0
    double threshold = 0.0;   ///< r >= 0, input units
  };
  using Operators = std::vector<Operator>;
  using State = std::vector<double>;  ///< memory y_i of each operator
  /// Returns the state after the input was held for a very long time: every y_i = input.
  static State settled(const Operators& operators, double input) { return State(operators.size(), input); }

  /// Throws std::invalid_argument, with the operator's index, if a weight is not finite, a rate is not
  /// positive or a threshold is negative; also if dt_s is not positive.
  Creep(Operators operators, double dt_s);
  /// Returns the output after `input` was held for dt_s. An input that is not finite leaves the state
  /// unchanged.
  double operator()(State& state, double input) const;
  double output(const State& state) const;  ///< returns the creep: sum_i w_i y_i over all operators

 private:
  Operators operators_;
  std::vector<double> shares_;  // 1 - e^{-a dt}
};

/// Logarithmic creep for t in [from_s, to_s] after a step of the input:
///
///   x(t) = x_0 [1 + gamma log10(t / t_1)],    t_1 = from_s,    gamma = `per_decade`
///
/// gamma is 0.01 to 0.02 for piezo actuators.
/// H. Jung, D.-G. Gweon, "Creep characteristics of piezoelectric actuators", Rev. Sci. Instrum. 71(4), 2000.
/// This law has neither a beginning nor an end in time. It is approximated by linear operators (r = 0) of
/// weight gamma / 2, two per decade of time constants, from 10^{-1/2} from_s to at least 10^2 to_s. The
/// approximation errors, for the creep C(t) after a unit step at rest:
///   - dC / dlog10(t) equals gamma to 0.6 %: the spacing causes a ripple of 0.23 %, and the missing slower
///     operators make it up to 0.5 % too small near to_s.  C(t) - C(from_s) equals gamma log10(t / from_s)
///     to 0.24 % of gamma.
///   - C(from_s) = 1.00 gamma: the creep before t_1 belongs to x_0, which is (1 + gamma) times the response
///     without creep.  gamma is a share of that response.
///   - Before from_s the creep starts from zero, linear in time.  After to_s it slows down; it still
///     increases by 2 to 2.5 gamma in total.
///   - The approximation is linear: successive steps superpose. Real creep with its thresholds superposes
///     only roughly.
/// Throws std::invalid_argument if gamma is not finite or if 0 < from_s < to_s does not hold.
Creep::Operators logarithmic_creep(double per_decade, double from_s, double to_s);

}  // namespace hystcan::model
