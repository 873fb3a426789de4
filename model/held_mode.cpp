#include "model/held_mode.h"

#include <cmath>

#include "base/text.h"

namespace hystcan::model {
namespace {

Eigen::Vector2d state_after(const SecondOrder& step, const SecondOrder::State& state, double drive) {
  const SecondOrder::State after = step(state, drive, drive);
  return {after.position, after.velocity};
}

Eigen::Matrix2d transition_of(const SecondOrder& step) {
  Eigen::Matrix2d transition;
  transition << state_after(step, {1.0, 0.0}, 0.0), state_after(step, {0.0, 1.0}, 0.0);
  return transition;
}

}  // namespace

HeldMode::HeldMode(const SecondOrder::Config& mode, double delay_s, double cycle_s) {
  if (!std::isfinite(delay_s) || std::abs(delay_s) > 1e6 * cycle_s)
    refuse("delay_s = ", delay_s, ", expected less than a million cycles");
  const SecondOrder whole(mode, cycle_s);
  transition_ = transition_of(whole);
  const double cycles = std::floor(delay_s / cycle_s);
  whole_cycles_ = static_cast<int>(cycles);
  const double late_s = delay_s - cycles * cycle_s;  // part of the delay that is less than a cycle
  const double rest_s = cycle_s - late_s;
  if (late_s <= 0.0) {
    from_new_ = state_after(whole, {}, 1.0);
  } else if (rest_s <= 0.0) {  // the rest of the delay is a whole cycle: only by rounding errors
    from_old_ = state_after(whole, {}, 1.0);
  } else {
    const SecondOrder rest(mode, rest_s);
    from_new_ = state_after(rest, {}, 1.0);
    from_old_ = transition_of(rest) * state_after(SecondOrder(mode, late_s), {}, 1.0);
  }
}

std::complex<double> HeldMode::response(double theta) const {
  const std::complex<double> z = std::polar(1.0, theta);
  const Eigen::Vector2cd input = from_old_ / z + from_new_;
  const Eigen::Matrix2d& a = transition_;
  const std::complex<double> determinant = (z - a(0, 0)) * (z - a(1, 1)) - a(0, 1) * a(1, 0);
  return ((z - a(1, 1)) * input(0) + a(0, 1) * input(1)) / determinant *
         std::polar(1.0, -theta * whole_cycles_);
}

}  // namespace hystcan::model
