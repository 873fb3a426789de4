#include "twin/noise.h"

#include <cmath>
#include <numbers>

namespace hystcan::twin {

DriveNoise::DriveNoise(const Config& config, can::Duration substep, can::Time start, std::uint64_t seed)
    : sigma_(config.density_per_rtHz / std::sqrt(2.0 * can::seconds(substep))),
      ripple_(config.ripple),
      ripple_rad_per_s_(2.0 * std::numbers::pi * config.ripple_Hz),
      start_(start),
      normal_(normal_numbers(seed)) {}

double DriveNoise::operator()(can::Time time) {
  double noise = 0.0;
  if (sigma_ > 0.0) noise = sigma_ * normal_();
  if (ripple_ > 0.0) noise += ripple_ * std::sin(ripple_rad_per_s_ * can::seconds(time - start_));
  return noise;
}

}  // namespace hystcan::twin
