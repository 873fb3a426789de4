// A weighted sum of operators (plays, relays). The output is linear in the weights.
//
//   x = x_0 + w_0 v + sum_j w_j o_j[v],     w >= 0
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "identification/baselines/baseline_samples.h"

namespace hystcan::identification {

/// The values of o_j at every one of these samples, after a history.
using OperatorColumn =
    std::function<std::vector<double>(std::size_t j, const History& history, const Samples& samples)>;

struct WeightedOperators {
  History history;      ///< the given history that fits best
  double offset = 0.0;  ///< x_0
  double gain = 0.0;    ///< w_0
  std::vector<double> weights;
  std::vector<double> prediction;  ///< for every sample
};

/// The caller has checked the samples.
WeightedOperators fit_weights(const Samples& samples, const std::vector<History>& histories,
                              std::size_t operators, const OperatorColumn& column);

}  // namespace hystcan::identification
