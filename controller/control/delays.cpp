#include "controller/control/delays.h"

namespace hystcan::controller {

Moments Delays::moments(double cycle_s) const {
  constexpr double two_pi = 2.0 * std::numbers::pi;
  const double omega = two_pi * resonance_Hz;
  const double means = interpolated ? 2.0 : 1.0;  // over a cycle each
  return {.mean_s = std::chrono::duration<double>(command_delay).count() + means * cycle_s / 2.0 + lag_s() +
                    2.0 * damping_ratio / omega,
          .variance_s2 = means * cycle_s * cycle_s / 12.0 + lag_s() * lag_s() +
                         (4.0 * damping_ratio * damping_ratio - 2.0) / (omega * omega)};
}

double Delays::sensor_s() const {
  const double delay_s = std::chrono::duration<double>(sensor_delay).count();
  return sensor_bandwidth_Hz > 0.0 ? delay_s + 1.0 / (2.0 * std::numbers::pi * sensor_bandwidth_Hz) : delay_s;
}

}  // namespace hystcan::controller
