#include "model/simplified.h"

#include <algorithm>

namespace hystcan::model {
namespace {

HysteresisParameters on_one_curve(const HysteresisParameters& parameters,
                                  const std::vector<double>& chebyshev) {
  const ReferenceCurve curve(Basis::chebyshev, chebyshev, parameters.ascending.domain());
  HysteresisParameters result = parameters;
  result.ascending = curve;
  result.descending = curve;
  result.k_ascending = 0.0;
  result.k_descending = 0.0;
  return result;
}

}  // namespace

HysteresisParameters average(const HysteresisParameters& parameters) {
  const auto& ascending = parameters.ascending.chebyshev_coefficients();
  const auto& descending = parameters.descending.chebyshev_coefficients();
  std::vector<double> mean(std::max(ascending.size(), descending.size()));
  for (std::size_t i = 0; i < ascending.size(); ++i) mean[i] += 0.5 * ascending[i];
  for (std::size_t i = 0; i < descending.size(); ++i) mean[i] += 0.5 * descending[i];
  return on_one_curve(parameters, mean);
}

HysteresisParameters straight_line(const HysteresisParameters& parameters) {
  const double low = parameters.lower_point().output, high = parameters.upper_point().output;
  return on_one_curve(parameters, {0.5 * (low + high), 0.5 * (high - low)});
}

}  // namespace hystcan::model
