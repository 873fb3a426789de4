// The numbers of a trial that the search moves.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "identification/quantity.h"
#include "identification/search.h"

namespace hystcan::identification {

/// One of them, on a scale where a step of one is reasonable.
struct Unknown {
  Quantity quantity;
  double start = 0.0;
  double step = 0.5;
  std::function<void(Trial&, double)> set;
};

/// The start values or the steps.
Eigen::VectorXd numbers_of(const std::vector<Unknown>& unknowns, double Unknown::*number);
/// The trial, moved to these values of the unknowns.
Trial moved_to(const Eigen::VectorXd& values, const std::vector<Unknown>& unknowns, Trial trial);

/// k_ascending, then k_descending.
std::vector<Unknown> both_k(const Trial& trial);
/// The bias of the initial memory of a dataset.
Unknown bias_of(std::size_t dataset, double start);
/// The delay, from `unit_s` on, in this unit.
Unknown delay_of(double unit_s);
/// The gain of a dataset against the first one.
Unknown gain_of(std::size_t dataset, double start);
/// What can be searched beside `used`.
std::vector<Unknown> candidates(const Trial& trial, const std::vector<Unknown>& used, const Problem& problem,
                                const IdentifyOptions& options);

}  // namespace hystcan::identification
