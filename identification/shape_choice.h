// Derives the shape of the reference curves from the samples, before a fit.
#pragma once

#include <functional>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// Returns a function for the knots of a spline with a given number of pieces, from one end of the observed
/// inputs to the other. The knots are close together where the output is steep, and follow the density of
/// inputs. They divide the inputs into equal shares. The share of an interval consists of one third each of
/// its length, of the change of the outputs in it, and of the number of samples in it.
std::function<std::vector<double>(int)> knot_places(const std::vector<Dataset>& datasets,
                                                    model::Interval observed);

/// Returns the mean output over the input, without hysteresis: the mean of two functions, one for rising and
/// one for falling inputs, each the nearest function that never falls (isotonic regression by pooling
/// adjacent violators; R. Barlow, D. Bartholomew, J. Bremner, H. Brunk, "Statistical Inference under Order
/// Restrictions", 1972). The samples are those of the excerpts at the trial's delay and gains, without the
/// offsets.
std::function<double(double)> mean_course(const Problem& problem, const Trial& trial,
                                          const std::vector<double>& offsets);

}  // namespace hystcan::identification
