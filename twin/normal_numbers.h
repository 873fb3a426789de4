// Normally distributed random numbers. Generator and transformation are Boost's, whose numbers, unlike those of
// <random>, do not depend on the standard library.
#pragma once

#include <cstdint>
#include <memory>

namespace hystcan::twin {

class NormalNumbers {
 public:
  /// The same seed gives the same numbers on every host.
  explicit NormalNumbers(std::uint64_t seed);
  NormalNumbers(NormalNumbers&&) noexcept;
  NormalNumbers& operator=(NormalNumbers&&) noexcept;
  ~NormalNumbers();

  /// The next number, with mean 0 and standard deviation 1.
  double next();

 private:
  struct Generator;  // keeps Boost's headers out of this one
  std::unique_ptr<Generator> generator_;
};

}  // namespace hystcan::twin
