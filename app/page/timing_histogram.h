// Times in classes of 1, 2, 5, 10 ... us.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace hystcan::app {

class TimingHistogram {
 public:
  static constexpr auto upper_us = std::to_array<double>(
      {1, 2, 5, 10, 20, 50, 100, 200, 500, 1'000, 2'000, 5'000, 10'000, 20'000, 50'000, 100'000});

  /// NaN does not count.
  void put(double time_us) {
    if (std::isnan(time_us)) return;
    const auto edge = std::ranges::lower_bound(upper_us, time_us);
    ++counts_[static_cast<std::size_t>(edge - upper_us.begin())];
    ++samples_;
    sum_us_ += time_us;
  }
  /// One more than there are edges: the last class has none.
  const std::array<std::uint64_t, upper_us.size() + 1>& counts() const { return counts_; }
  std::uint64_t samples() const { return samples_; }
  double sum_us() const { return sum_us_; }

 private:
  std::array<std::uint64_t, upper_us.size() + 1> counts_{};
  std::uint64_t samples_ = 0;
  double sum_us_ = 0.0;
};

}  // namespace hystcan::app
