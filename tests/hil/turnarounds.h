// The times from a sample on the wire to its command on the wire, from a candump log with both.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace hystcan::hil {

/// Returns the times in us, ascending. The log contains the frames 182 (sample of the first axis) and 201
/// (its command).
inline std::vector<double> turnarounds(const std::string& log) {
  std::vector<double> result;
  double sampled_s = 0.0;  // 0: already answered
  std::ifstream file(log);
  for (std::string line; std::getline(file, line);) {
    const double time_s = std::strtod(line.c_str() + 1, nullptr);
    const std::string frame = line.substr(line.rfind(' ') + 1);
    if (frame.starts_with("182#")) sampled_s = time_s;
    if (!frame.starts_with("201#") || sampled_s == 0.0) continue;
    result.push_back(1e6 * (time_s - sampled_s));
    sampled_s = 0.0;
  }
  std::ranges::sort(result);
  return result;
}

inline double quantile(const std::vector<double>& ascending, double q) {
  return ascending.at(static_cast<std::size_t>(q * static_cast<double>(ascending.size() - 1)));
}

/// Prints quantiles and a histogram of ascending times in us; tests/hil/kernels reads this output.
inline void print_times(const char* who, const char* what, const std::vector<double>& us) {
  std::printf("%-10s %6zu %s: p50 %6.1f us, p99 %6.1f us, p99.9 %6.1f us, max %6.1f us\n", who, us.size(),
              what, quantile(us, 0.5), quantile(us, 0.99), quantile(us, 0.999), us.back());
  constexpr double bin_us = 5.0;
  for (std::size_t i = 0; i < us.size();) {
    const double top = bin_us * (std::floor(us[i] / bin_us) + 1.0);
    const std::size_t first = i;
    while (i < us.size() && us[i] < top) ++i;
    std::printf("    %5.0f..%-5.0f us %6zu\n", top - bin_us, top, i - first);
  }
}

inline void print_turnarounds(const char* who, const std::vector<double>& us) {
  print_times(who, "turnarounds", us);
}

}  // namespace hystcan::hil
