#include "identification/error_by_rate.h"

#include <algorithm>
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
  std::size_t begin = 0;
  const auto add = [&](std::size_t end) {
    const double way = std::abs(dataset.input[end - 1] - dataset.input[begin]);
    const double lasts_s = dataset.time_s[end - 1] - dataset.time_s[begin];
    if (way > 0.05 * range && lasts_s > 0.0) {
      Class& of = classes[static_cast<int>(std::floor(std::log2(way / lasts_s)))];
      of.way += way;
      of.lasts_s += lasts_s;
      of.samples += end - begin;
      for (std::size_t i = begin; i < end; ++i)
        of.square += (predicted[i] - dataset.output[i]) * (predicted[i] - dataset.output[i]);
    }
    begin = end - 1;
  };
  std::size_t i = 0;
  for (const TurningPoint& point : turning_points(dataset, 0.02 * range)) {
    while (i < dataset.size() && dataset.time_s[i] < point.time_s) ++i;
    if (i > begin) add(i + 1);
  }
  if (dataset.size() > begin + 1) add(dataset.size());
  std::vector<RateError> errors;
  errors.reserve(classes.size());
  for (const auto& [octave, of] : classes)
    errors.push_back(
        {of.way / of.lasts_s, std::sqrt(of.square / static_cast<double>(of.samples)), of.samples});
  return errors;
}

}  // namespace hystcan::identification
