// Where the knots of a spline belong: close together where the output is steep, and wherever there are inputs.
#pragma once

#include <vector>

#include "identification/dataset.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

class KnotPlaces {
 public:
  /// `observed`: range of all inputs. The share of a part of the inputs is a third each of its length, of the
  /// way that the outputs go in it, and of the samples in it.
  KnotPlaces(const std::vector<Dataset>& datasets, model::Interval observed);

  /// pieces + 1 knots from one end of the observed inputs to the other; between them lie equal shares.
  std::vector<double> knots(int pieces) const;

 private:
  std::vector<double> borders_;  // of cells with about the same number of samples
  std::vector<double> share_;    // of each cell; their sum is 1
};

}  // namespace hystcan::identification
