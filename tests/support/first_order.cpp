#include "tests/support/first_order.h"

#include <cmath>
#include <numbers>

#include "base/text.h"

namespace hystcan::support {
namespace {

struct Shares {
  long double before = 0, after = 0;  // b_0, b_1
};

// For tau < 1, where the closed form is a difference of nearly equal numbers:
//   b_0 = -sum j (-tau)^j / (j+1)!,    b_1 = -sum (-tau)^j / (j+1)!,    j = 1, 2, ...
Shares by_series(long double tau) {
  Shares b;
  long double term = tau / 2;  // -(-tau)^j / (j+1)!
  for (int j = 1; std::abs(term) > 1e-22L * tau; ++j) {
    b.before += j * term;
    b.after += term;
    term *= -tau / (j + 2);
  }
  return b;
}

Shares by_closed_form(long double tau) {
  const long double mean = -std::expm1(-tau) / tau;
  return {mean - std::exp(-tau), 1 - mean};
}

void check(const char* what, double value) {
  if (std::isfinite(value) && value > 0) return;
  refuse(what, " = ", value, ", expected a positive number");
}

}  // namespace

FirstOrder::Step::Step(const Config& config, double dt_s) {
  check("bandwidth_Hz", config.bandwidth_Hz);
  check("dt_s", dt_s);
  const long double tau = 2 * std::numbers::pi_v<long double> * config.bandwidth_Hz * dt_s;
  const Shares b = tau < 1 ? by_series(tau) : by_closed_form(tau);
  from_before_ = static_cast<double>(b.before);
  from_after_ = static_cast<double>(b.after);
}

FirstOrder::State FirstOrder::Step::operator()(const State& state, double input_before,
                                               double input_after) const {
  const double x = state.value;
  return {x + from_before_ * (input_before - x) + from_after_ * (input_after - x)};
}

}  // namespace hystcan::support
