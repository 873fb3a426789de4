#include "identification/error_by_rate.h"

#include <cmath>
#include <map>

#include "identification/excerpt.h"
#include "identification/prediction.h"

namespace hystcan::identification {

std::vector<RateError> errors_by_rate(const Dataset& dataset, const std::vector<double>& predicted) {
  const double range = span_of(dataset.input);
  struct Class {
    double way = 0.0, lasts_s = 0.0, square = 0.0;
    std::size_t samples = 0;
  };
  std::map<int, Class> classes;
  for (const HalfCycle& half : half_cycles(dataset, 0.02 * range)) {
    const double way = std::abs(half.to - half.from);
    const double lasts_s = dataset.time_s[half.end - 1] - dataset.time_s[half.begin];
    if (!(way > 0.05 * range) || !(lasts_s > 0.0)) continue;
    Class& of = classes[static_cast<int>(std::floor(std::log2(way / lasts_s)))];
    of.way += way;
    of.lasts_s += lasts_s;
    of.samples += half.end - half.begin;
    for (std::size_t i = half.begin; i < half.end; ++i)
      of.square += (predicted[i] - dataset.output[i]) * (predicted[i] - dataset.output[i]);
  }
  std::vector<RateError> errors;
  errors.reserve(classes.size());
  for (const auto& [octave, of] : classes)
    errors.push_back(
        {of.way / of.lasts_s, std::sqrt(of.square / static_cast<double>(of.samples)), of.samples});
  return errors;
}

}  // namespace hystcan::identification
