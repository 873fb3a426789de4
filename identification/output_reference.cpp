#include "identification/output_reference.h"

#include <cmath>
#include <cstddef>
#include <numeric>

namespace hystcan::identification {
namespace {

constexpr double most_spans_from_zero = 10.0;
// Minimum span of an output that is not constant, as a share of the output's magnitude. characterisation.h
// refuses a constant output.
constexpr double constant_output = 1e-12;

double reference_of(const Dataset& dataset) {
  if (dataset.size() == 0) return 0.0;
  const model::Interval range = range_of(dataset.output);
  const double middle = std::midpoint(range.lo, range.hi), distance = std::abs(middle);
  return distance > most_spans_from_zero * range.span() && range.span() > constant_output * distance ? middle
                                                                                                     : 0.0;
}

model::ReferenceCurve moved(const model::ReferenceCurve& curve, double by) {
  std::vector<double> coefficients = curve.coefficients();
  // Adds a constant to the curve. For a spline, this changes every coefficient, because the B-splines add up
  // to 1; for a Chebyshev series, it changes only the first coefficient.
  const bool all = curve.basis() == model::Basis::spline;
  for (std::size_t i = 0; i < coefficients.size(); ++i) coefficients[i] += all || i == 0 ? by : 0.0;
  return curve.with(coefficients);
}

}  // namespace

std::vector<double> reference_outputs(const std::vector<Dataset>& datasets, bool one_zero) {
  std::vector<double> references;
  references.reserve(datasets.size());
  for (const Dataset& dataset : datasets)
    references.push_back(one_zero && !references.empty() ? references.front() : reference_of(dataset));
  return references;
}

void move_outputs(std::vector<Dataset>& datasets, const std::vector<double>& references, double sign) {
  for (std::size_t i = 0; i < datasets.size(); ++i)
    for (double& output : datasets[i].output) output += sign * references[i];
}

void move_outputs(Identified& identified, const std::vector<double>& references, double sign) {
  model::HysteresisParameters& p = identified.parameters;
  const double by = sign * references.front();
  if (p.output_map) {
    std::vector<double> map = p.output_map->coefficients();
    map.front() += by;
    p.output_map.emplace(map, p.output_map->inner());
  } else {
    p.ascending = moved(p.ascending, by);
    p.descending = moved(p.descending, by);
  }
  for (std::size_t i = 0; i < identified.offsets.size(); ++i)
    identified.offsets[i] += sign * (references[i] - identified.gains[i] * references.front());
}

}  // namespace hystcan::identification
