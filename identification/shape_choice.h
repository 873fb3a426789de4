// What the samples say of the shape of the reference curves, before a fit.
#pragma once

#include <functional>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

/// The knots of a spline with a number of pieces, from one end of the observed inputs to the other: close
/// together where the output is steep, and wherever there are inputs. Between knots lie equal shares; the
/// share of a part of the inputs is a third each of its length, of the way that the outputs go in it, and of
/// the samples in it.
std::function<std::vector<double>(int)> knot_places(const std::vector<Dataset>& datasets,
                                                    model::Interval observed);

/// The course of the outputs over the inputs, without hysteresis: the mean of two functions, one for rising
/// and one for falling inputs, each the nearest one that never falls (isotonic regression by pooling adjacent
/// violators; R. Barlow, D. Bartholomew, J. Bremner, H. Brunk, "Statistical Inference under Order
/// Restrictions", 1972). The samples are those of the excerpts at the trial's delay and gains, without the
/// offsets.
std::function<double(double)> mean_course(const Problem& problem, const Trial& trial,
                                          const std::vector<double>& offsets);

}  // namespace hystcan::identification
