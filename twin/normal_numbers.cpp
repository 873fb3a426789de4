#include "twin/normal_numbers.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

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

}  // namespace hystcan::twin
