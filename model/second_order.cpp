#include "model/second_order.h"

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace hystcan::model {
namespace {

using Matrix = Eigen::Matrix<long double, 4, 4>;

// In tau = omega t the augmented state (x, dx/dtau, u, du/dtau) obeys one constant matrix, for every damping
// alike.
Matrix generator(double damping_ratio) {
  Matrix m = Matrix::Zero();
  m(0, 1) = 1;
  m(1, 0) = -1;
  m(1, 1) = -2 * static_cast<long double>(damping_ratio);
  m(1, 2) = 1;
  m(2, 3) = 1;
  return m;
}

// Taylor series of a scaled-down step, squared up again. Every entry is relatively accurate for small steps,
// where a closed form in sines would lose the input's share (of order tau^2) in a difference of nearly equal
// numbers.
Matrix exponential(const Matrix& m, long double tau) {
  const long double norm = m.cwiseAbs().rowwise().sum().maxCoeff() * tau;
  const int halvings = norm > 0.5L ? std::ilogb(norm) + 2 : 0;
  const Matrix scaled = m * std::ldexp(tau, -halvings);
  Matrix term = Matrix::Identity(), sum = Matrix::Identity();
  for (int j = 1; j <= 24; ++j) {
    term = (term * scaled / static_cast<long double>(j)).eval();
    sum += term;
  }
  for (int i = 0; i < halvings; ++i) sum = (sum * sum).eval();
  return sum;
}

void check(const SecondOrder::Config& config, double dt_s) {
  const auto refuse = [](const char* what, double value, const char* expected) {
    throw std::invalid_argument(std::string(what) + " = " + std::to_string(value) + ", expected " + expected);
  };
  if (!std::isfinite(config.natural_frequency_Hz) || config.natural_frequency_Hz <= 0)
    refuse("natural_frequency_Hz", config.natural_frequency_Hz, "a positive number");
  if (!std::isfinite(config.damping_ratio) || config.damping_ratio < 0)
    refuse("damping_ratio", config.damping_ratio, "a number, zero or more");
  if (!std::isfinite(dt_s) || dt_s <= 0) refuse("dt_s", dt_s, "a positive number");
}

}  // namespace

SecondOrder::Step::Step(const Config& config, double dt_s) {
  check(config, dt_s);
  const long double omega = 2 * std::numbers::pi_v<long double> * config.natural_frequency_Hz;
  const long double tau = omega * dt_s;
  if (tau * (1 + 2 * config.damping_ratio) > 1e6L)
    throw std::invalid_argument("step of " + std::to_string(dt_s) + " s at " +
                                std::to_string(config.natural_frequency_Hz) +
                                " Hz, expected less than a million time constants");
  const Matrix step = exponential(generator(config.damping_ratio), tau);
  const auto from_after = [&](int row) { return step(row, 3) / tau; };
  const auto from_before = [&](int row) { return step(row, 2) - step(row, 3) / tau; };
  position_from_velocity_ = static_cast<double>(step(0, 1) / omega);
  position_from_before_ = static_cast<double>(from_before(0));
  position_from_after_ = static_cast<double>(from_after(0));
  velocity_from_velocity_ = static_cast<double>(step(1, 1));
  velocity_from_before_ = static_cast<double>(from_before(1) * omega);
  velocity_from_after_ = static_cast<double>(from_after(1) * omega);
}

SecondOrder::State SecondOrder::Step::operator()(const State& state, double input_before,
                                                 double input_after) const {
  const double before = input_before - state.position;
  const double after = input_after - state.position;
  return {state.position + position_from_velocity_ * state.velocity + position_from_before_ * before +
              position_from_after_ * after,
          velocity_from_velocity_ * state.velocity + velocity_from_before_ * before +
              velocity_from_after_ * after};
}

}  // namespace hystcan::model
