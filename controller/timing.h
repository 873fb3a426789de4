// Statistics of the times of a cycle, collected on the control thread. They are always on, cost a few
// nanoseconds each, and use fixed storage. Mean and standard deviation SD follow from each new time x_n
// (Welford, Technometrics 4 (1962) 419):
//
//   mean_n = mean_(n-1) + (x_n - mean_(n-1)) / n
//   S_n    = S_(n-1) + (x_n - mean_(n-1)) (x_n - mean_n)     S_n: sum of squared differences from the mean
//   SD     = sqrt(S_n / (n - 1))
//
// Quantiles are computed from a histogram. Its classes are 1 ns wide up to 64 ns; above that, each doubling
// has 32 classes. A quantile is reported as the upper end of its class: it is never less than the true
// quantile and at most 1/32 (3.1 %) above it. All times above 68 s are in one class, which is reported as the
// maximum.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace hystcan::controller {

struct TimeSummary {
  std::uint64_t count = 0;
  double mean_us = 0.0;
  double sd_us = 0.0;  ///< standard deviation; 0 if count < 2
  double p99_us = 0.0;
  double max_us = 0.0;
};

class TimeStatistics {
 public:
  void add(std::chrono::nanoseconds time);

  std::uint64_t count() const { return count_; }
  /// Returns the quantile `q` (0..1): the smallest time that is not exceeded by the share `q` of all times.
  /// Returns 0 if there are no times.
  double quantile_us(double q) const;
  TimeSummary summary() const;

 private:
  /// Number of bits that select a class: 2^5 = 32 classes per doubling of the time.
  static constexpr unsigned sub_bits = 5;
  static constexpr unsigned top_bits = 36;  ///< times above 2^36 ns (68 s) are in the last class
  static constexpr std::size_t classes = (top_bits - sub_bits + 1) << sub_bits;
  static std::size_t class_of(std::uint64_t ns);
  static std::uint64_t upper_end_ns(std::size_t index);

  std::uint64_t count_ = 0;
  double mean_ns_ = 0.0;
  double squares_ns2_ = 0.0;  ///< sum of the squared differences from the mean
  double max_ns_ = 0.0;
  std::array<std::uint64_t, classes> histogram_{};
};

/// The times of one controller since its start. Each cycle adds one time to `period` and `lateness`, and one
/// time per axis to the other members.
struct CycleTiming {
  TimeStatistics period;      ///< time from one SYNC to the next
  TimeStatistics lateness;    ///< delay of the SYNC after its deadline
  TimeStatistics turnaround;  ///< time from sample arrival (kernel's timestamp) to sent command
  TimeStatistics execution;   ///< execution time of the axis's step
};

struct NamedTime {
  std::string_view key;  ///< JSON key of the statistics to which `statistics` points
  std::string_view words;
  TimeStatistics CycleTiming::*statistics;
};
std::span<const NamedTime> cycle_times();

/// Describes the times in one line. Example for 5000 times: `period 5000 x, mean 1000.0 us, SD 1.2 us, p99
/// 1003.5 us, max 1010.2 us`.
std::string describe(std::string_view words, const TimeSummary& summary);

}  // namespace hystcan::controller
