// Finds shapes for the reference curves from the samples, before a fit: the knots of splines, and the mean
// course of the output.
#pragma once

#include <functional>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// Returns a function that gives the knots of a spline for a number of pieces. The knots extend over the
/// range `observed`. They are close together where the output is steep and where many samples are. More
/// exactly, they divide the range into pieces of equal weight. The weight of a piece is the mean of three
/// shares: of the length, of the change of the output, and of the number of samples.
std::function<std::vector<double>(int)> knot_places(const std::vector<Dataset>& datasets,
                                                    model::Interval observed);

/// Returns the mean output as a function of the input, without hysteresis. It is the mean of two functions,
/// for rising and for falling inputs. Each of them is the closest function that never falls (isotonic
/// regression by pooling adjacent violators; R. Barlow, D. Bartholomew, J. Bremner, H. Brunk, "Statistical
/// Inference under Order Restrictions", 1972). The samples are those of `problem`, after correction for the
/// delay, creep and gains of `trial` and for `offsets`, one offset for each dataset.
std::function<double(double)> mean_course(const Problem& problem, const Trial& trial,
                                          const std::vector<double>& offsets);

}  // namespace hystcan::identification
