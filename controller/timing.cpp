#include "controller/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace hystcan::controller {
namespace {

constexpr std::array<NamedTime, 4> times{{
    {"period", "period", &CycleTiming::period},
    {"wake_up", "wake-up", &CycleTiming::lateness},
    {"turnaround", "turnaround", &CycleTiming::turnaround},
    {"execution", "execution", &CycleTiming::execution},
}};

}  // namespace

void TimeStatistics::add(std::chrono::nanoseconds time) {
  const auto ns = static_cast<double>(time.count());
  ++count_;
  const double from_old_mean = ns - mean_ns_;
  mean_ns_ += from_old_mean / static_cast<double>(count_);
  squares_ns2_ += from_old_mean * (ns - mean_ns_);
  max_ns_ = count_ == 1 ? ns : std::max(max_ns_, ns);
  ++histogram_[class_of(static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0)))];
}

/// Returns the index of the histogram class that contains the time `ns`. Each time below 2^sub_bits ns has
/// its own class. All longer times with the same highest bit share 2^sub_bits classes; the `sub_bits` bits
/// after the highest bit select one of these classes.
std::size_t TimeStatistics::class_of(std::uint64_t ns) {
  if (ns < std::uint64_t{1} << sub_bits) return ns;
  const auto shift = static_cast<unsigned>(std::bit_width(ns)) - 1 - sub_bits;
  const std::size_t index = (std::size_t{shift} << sub_bits) + (ns >> shift);
  return std::min(index, classes - 1);
}

std::uint64_t TimeStatistics::upper_end_ns(std::size_t index) {
  if (index < std::size_t{1} << sub_bits) return index;
  const std::size_t shift = (index >> sub_bits) - 1;
  const std::uint64_t lower = (index - (shift << sub_bits)) << shift;
  return lower + (std::uint64_t{1} << shift) - 1;
}

double TimeStatistics::quantile_us(double q) const {
  if (count_ == 0) return 0.0;
  const auto rank = std::max(1.0, std::ceil(q * static_cast<double>(count_)));
  std::uint64_t below = 0;
  for (std::size_t i = 0; i + 1 < classes; ++i) {
    below += histogram_[i];
    if (static_cast<double>(below) >= rank)
      return 1e-3 * std::min(static_cast<double>(upper_end_ns(i)), std::max(max_ns_, 0.0));
  }
  return 1e-3 * max_ns_;
}

TimeSummary TimeStatistics::summary() const {
  return {.count = count_,
          .mean_us = 1e-3 * mean_ns_,
          .sd_us = count_ < 2 ? 0.0 : 1e-3 * std::sqrt(squares_ns2_ / static_cast<double>(count_ - 1)),
          .p99_us = quantile_us(0.99),
          .max_us = 1e-3 * max_ns_};
}

std::span<const NamedTime> cycle_times() { return times; }

std::string describe(std::string_view words, const TimeSummary& summary) {
  if (summary.count == 0) return fmt::format("{:<10} none", words);
  return fmt::format("{:<10} {} x, mean {:.1f} us, SD {:.1f} us, p99 {:.1f} us, max {:.1f} us", words,
                     summary.count, summary.mean_us, summary.sd_us, summary.p99_us, summary.max_us);
}

}  // namespace hystcan::controller
