// What an amplifier's output carries beside the drive: white noise and a ripple.
//
//   n(t) = sigma N(0, 1) + ripple sin(2 pi f (t - start)),   sigma = density / sqrt(2 dt)
//
// The noise is drawn once for each sub-step dt and held over it: white up to 1 / (2 dt) with the one-sided
// density that a data sheet states, so that its variance is density^2 / (2 dt). What is behind it, the mode,
// filters it. Above 1 / (2 dt) there is neither noise nor a ripple.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cstdint>

#include "can/scheduler.h"

namespace hystcan::twin {

class DriveNoise {
 public:
  struct Config {
    double density_per_rtHz = 0.0;  ///< one-sided, drive units / sqrt(Hz), >= 0
    double ripple = 0.0;            ///< amplitude, half of what is stated peak to peak, drive units
    double ripple_Hz = 0.0;
  };

  /// `substep`: for how long a value is held. The same seed gives the same noise on every host.
  DriveNoise(const Config& config, can::Duration substep, can::Time start, std::uint64_t seed);

  /// Drive units, for the sub-step that begins or ends at `time`; to be asked once for each.
  double operator()(can::Time time);
  bool is_silent() const { return sigma_ == 0.0 && ripple_ == 0.0; }

 private:
  double sigma_;
  double ripple_;
  double ripple_rad_per_s_;
  can::Time start_;
  boost::random::mt19937_64 random_;
  boost::random::normal_distribution<double> normal_;
};

}  // namespace hystcan::twin
