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
/// Returns a different seed for each pair of node and channel, because node numbers are below 128.
constexpr std::uint64_t seed_of(std::uint64_t seed, std::uint8_t node, std::size_t channel) {
  return seed + node + 256 * channel;
}

// The noise n(t) of an amplifier's output, added to the drive, in drive units:
//
//   n(t) = sigma N(0, 1) + ripple sin(2 pi f (t - start)),   sigma = density / sqrt(2 dt)
//
// dt is the sub-step of the plant, f is the frequency of the ripple, `start` is the start of the twin. The
// term N(0, 1) is a normally distributed random number with mean 0 and standard deviation 1. One number is
// drawn for each sub-step, and n is constant within the sub-step. So the random part is white up to 1 / (2
// dt). `density` is the one-sided noise density of a data sheet, so the variance of the random part is
// density^2 / (2 dt). The output contains no noise and no ripple above the frequency 1 / (2 dt).

class DriveNoise {
 public:
  struct Config {
    double density_per_rtHz = 0.0;  ///< one-sided noise density, drive units / sqrt(Hz), >= 0
    double ripple = 0.0;            ///< amplitude of the ripple (half peak-to-peak), drive units
    double ripple_Hz = 0.0;
  };

  /// Each value of the noise is constant for the time `substep`. The same seed gives the same noise on every
  /// host.
  DriveNoise(const Config& config, can::Duration substep, can::Time start, std::uint64_t seed);

  /// Returns noise plus ripple, in drive units, for the sub-step that begins at `time`. The caller calls this
  /// operator once per sub-step.
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
