// The position sensor: Gaussian noise, then quantisation.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>
#include <cstdint>

namespace hystcan::twin {

class Sensor {
 public:
  struct Config {
    double noise_um_rms = 0.0;   ///< standard deviation of one sample, >= 0
    double resolution_um = 0.0;  ///< least significant bit; 0: not quantised
  };

  /// The same seed gives the same noise on every host.
  Sensor(const Config& config, std::uint64_t seed) : config_(config), random_(seed) {}

  double measure(double position_um);

 private:
  Config config_;
  boost::random::mt19937_64 random_;
  boost::random::normal_distribution<double> normal_;
};

}  // namespace hystcan::twin
