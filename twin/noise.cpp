#include "twin/noise.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

#include <cmath>
#include <numbers>

namespace hystcan::twin {

struct NormalNumbers::Generator {
  boost::random::mt19937_64 random;
  boost::random::normal_distribution<double> normal{};
};

NormalNumbers::NormalNumbers(std::uint64_t seed)
    : generator_(std::make_unique<Generator>(Generator{boost::random::mt19937_64(seed)})) {}
NormalNumbers::NormalNumbers(NormalNumbers&&) noexcept = default;
NormalNumbers& NormalNumbers::operator=(NormalNumbers&&) noexcept = default;
NormalNumbers::~NormalNumbers() = default;

double NormalNumbers::next() { return generator_->normal(generator_->random); }

DriveNoise::DriveNoise(const Config& config, can::Duration substep, can::Time start, std::uint64_t seed)
    : sigma_(config.density_per_rtHz / std::sqrt(2.0 * can::seconds(substep))),
      ripple_(config.ripple),
      ripple_rad_per_s_(2.0 * std::numbers::pi * config.ripple_Hz),
      start_(start),
      normal_(seed) {}

double DriveNoise::operator()(can::Time time) {
  double noise = 0.0;
  if (sigma_ > 0.0) noise = sigma_ * normal_.next();
  if (ripple_ > 0.0) noise += ripple_ * std::sin(ripple_rad_per_s_ * can::seconds(time - start_));
  return noise;
}

}  // namespace hystcan::twin
