// Creep: the slow drift that follows a change of input, as a sum of threshold-discrete operators.
//
//   y_i' = a_i max(u - y_i - r_i, min(u - y_i + r_i, 0)),    output = sum_i w_i y_i
//
// Input u; thresholds r_i >= 0 and memories y_i in input units; rates a_i > 0 in 1/s; weights w_i in output
// units per input unit.  Each y_i follows u at its own rate and stops r_i short of it; r_i = 0 is the linear
// lag.  Kuhnen has an operator for every pair of a threshold and a rate; here they are one list.  Exact for
// an input held during the step:
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

struct Creep {
  struct Operator {
    double weight = 0.0;      ///< w, output units per input unit, of either sign
    double rate_per_s = 1.0;  ///< a > 0
    double threshold = 0.0;   ///< r >= 0, input units
  };
  struct Config {
    std::vector<Operator> operators;
  };
  struct State {
    std::vector<double> values;  ///< y_i, one for each operator
  };
  /// Settled after an input that was held for ever: every y_i = input.
  static State settled(const Config& config, double input);

  /// The step of a fixed length, its coefficients computed once. Takes the states of its own Config only:
  /// as many values as there are operators. Allocates nothing.
  class Step {
   public:
    /// Throws std::invalid_argument, naming the operator's index, where a weight is not finite, a rate not
    /// positive or a threshold negative; and where dt_s is not positive.
    Step(const Config& config, double dt_s);
    /// The output after `input` was held for dt_s. An input that is not finite changes nothing.
    double operator()(State& state, double input) const;
    double output(const State& state) const;  ///< sum_i w_i y_i

   private:
    struct Coefficients {
      double weight, share, threshold;  // w, 1 - e^{-a dt}, r
    };
    std::vector<Coefficients> coefficients_;
  };
};

/// Logarithmic creep for t in [from_s, to_s] after a step of the input:
///
///   x(t) = x_0 [1 + gamma log10(t / t_1)],    t_1 = from_s,    gamma = `per_decade`
///
/// gamma is 0.01 to 0.02 for piezo actuators.
/// H. Jung, D.-G. Gweon, "Creep characteristics of piezoelectric actuators", Rev. Sci. Instrum. 71(4), 2000.
/// It has neither beginning nor end in time, and is approximated by linear operators (r = 0) of weight
/// gamma / 2, two to a decade of time constants, from 10^{-1/2} from_s to at least 10^2 to_s.
/// What is approximate, for the creep C(t) after a unit step at rest:
///   - dC / dlog10(t) is gamma to 0.6 %: 0.23 % of ripple from the spacing, and up to 0.5 % too little near
///     to_s, where the slower operators are missing.  C(t) - C(from_s) is gamma log10(t / from_s) to 0.24 %
///     of gamma.
///   - C(from_s) = 1.00 gamma: what has crept before t_1 belongs to x_0, which is (1 + gamma) times the
///     response without creep.  gamma is a share of the latter.
///   - Before from_s the creep starts from zero, linear in time.  After to_s it slows down, and goes on by
///     2 to 2.5 gamma in all.
///   - It is linear: successive steps superpose, which real creep with its thresholds does only roughly.
/// Throws std::invalid_argument where gamma is not finite or not 0 < from_s < to_s.
Creep::Config logarithmic_creep(double per_decade, double from_s, double to_s);

}  // namespace hystcan::model
