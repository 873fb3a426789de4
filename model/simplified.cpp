#include "model/simplified.h"

#include <algorithm>

namespace hystcan::model {
namespace {

HysteresisParameters on_one_curve(const HysteresisParameters& parameters, const ReferenceCurve& curve) {
  HysteresisParameters result = parameters;
  result.ascending = curve;
  result.descending = curve;
  result.k_ascending = 0.0;
  result.k_descending = 0.0;
  return result;
}

}  // namespace

HysteresisParameters average(const HysteresisParameters& parameters) {
  const auto& ascending = parameters.ascending.coefficients();
  const auto& descending = parameters.descending.coefficients();
  std::vector<double> mean(std::max(ascending.size(), descending.size()));
  for (std::size_t i = 0; i < ascending.size(); ++i) mean[i] += 0.5 * ascending[i];
  for (std::size_t i = 0; i < descending.size(); ++i) mean[i] += 0.5 * descending[i];
  return on_one_curve(parameters, parameters.ascending.with(mean));
}

HysteresisParameters straight_line(const HysteresisParameters& parameters) {
  const double low = parameters.lower_point().output, high = parameters.upper_point().output;
  return on_one_curve(parameters,
                      {Basis::chebyshev, {0.5 * (low + high), 0.5 * (high - low)}, parameters.input_range()});
}

}  // namespace hystcan::model
