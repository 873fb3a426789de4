// The random numbers of a twin, and the noise of an amplifier's output.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/variate_generator.hpp>
#include <cstddef>
#include <cstdint>

#include "can/scheduler.h"

namespace hystcan::twin {

/// Random numbers with mean 0 and standard deviation 1. Boost's numbers, unlike those of <random>, do not
/// depend on the standard library: the same seed gives the same numbers on every host.
using NormalNumbers =
    boost::random::variate_generator<boost::random::mt19937_64, boost::random::normal_distribution<double>>;
inline NormalNumbers normal_numbers(std::uint64_t seed) {
  return NormalNumbers(boost::random::mt19937_64(seed), boost::random::normal_distribution<double>());
}
/// Returns a different seed for each axis of a node. Node numbers are below 128.
constexpr std::uint64_t seed_of(std::uint64_t seed, std::uint8_t node, std::size_t channel) {
  return seed + node + 256 * channel;
}

// Noise and ripple of an amplifier's output, added to the drive:
//
//   n(t) = sigma N(0, 1) + ripple sin(2 pi f (t - start)),   sigma = density / sqrt(2 dt)
//
// The noise is drawn once for each sub-step dt and constant within it. It is white up to 1 / (2 dt) and has
// the one-sided density of a data sheet, so its variance is density^2 / (2 dt). The mechanical mode filters
// it. Neither noise nor ripple exists above 1 / (2 dt).

class DriveNoise {
 public:
  struct Config {
    double density_per_rtHz = 0.0;  ///< one-sided, drive units / sqrt(Hz), >= 0
    double ripple = 0.0;            ///< amplitude, half of the peak-to-peak value, drive units
    double ripple_Hz = 0.0;
  };

  /// `substep`: the time for which a value is constant. The same seed gives the same noise on every host.
  DriveNoise(const Config& config, can::Duration substep, can::Time start, std::uint64_t seed);

  /// Returns the noise in drive units for the sub-step that begins or ends at `time`; call it once per
  /// sub-step.
  double operator()(can::Time time);
  bool is_silent() const { return sigma_ == 0.0 && ripple_ == 0.0; }

 private:
  double sigma_;
  double ripple_;
  double ripple_rad_per_s_;
  can::Time start_;
  NormalNumbers normal_;
};

}  // namespace hystcan::twin
