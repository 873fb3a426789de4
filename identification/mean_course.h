// The course of the outputs over the inputs, without hysteresis: the mean of two functions, one for rising and one for
// falling inputs, each the nearest one that never falls (isotonic regression by pooling adjacent violators; R. Barlow,
// D. Bartholomew, J. Bremner, H. Brunk, "Statistical Inference under Order Restrictions", 1972).
#pragma once

#include <array>
#include <vector>

#include "identification/separable_fit.h"

namespace hystcan::identification {

class MeanCourse {
 public:
  /// The samples of the excerpts at the trial's delay and gains, without the offsets.
  MeanCourse(const Problem& problem, const Trial& trial, const std::vector<double>& offsets);

  double operator()(double input) const;

 private:
  struct Course {
    std::vector<double> input, output;  ///< ascending; straight lines between them
  };
  std::array<Course, 2> courses_;
};

}  // namespace hystcan::identification
