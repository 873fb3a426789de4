#include "metrics/statistics.h"

#include <algorithm>
#include <cmath>

namespace hystcan::metrics {

void ErrorStatistics::add(double error_um) {
  ++samples;
  sum_of_squares += error_um * error_um;
  max_um = std::max(max_um, std::abs(error_um));
}

void ErrorStatistics::add(const ErrorStatistics& others) {
  samples += others.samples;
  sum_of_squares += others.sum_of_squares;
  max_um = std::max(max_um, others.max_um);
}

double ErrorStatistics::rms_um() const {
  return samples == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(samples));
}

Histogram Histogram::of_width(double width, std::size_t classes) {
  std::vector<double> edges(classes);
  for (std::size_t i = 0; i < classes; ++i) edges[i] = width * static_cast<double>(i + 1);
  return Histogram(std::move(edges));
}

void Histogram::add(double value) {
  if (!std::isfinite(value)) return;
  const auto edge = std::ranges::lower_bound(upper_edges_, value);
  ++counts_[static_cast<std::size_t>(edge - upper_edges_.begin())];
  ++samples_;
  sum_ += value;
}

}  // namespace hystcan::metrics
