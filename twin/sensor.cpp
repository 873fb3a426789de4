#include "twin/sensor.h"

#include <cmath>

namespace hystcan::twin {

double Sensor::measure(double position_um) {
  const double noisy = position_um + config_.noise_um_rms * normal_(random_);
  if (config_.resolution_um == 0.0) return noisy;
  return config_.resolution_um * std::round(noisy / config_.resolution_um);
}

}  // namespace hystcan::twin
