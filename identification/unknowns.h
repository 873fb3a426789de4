// The unknowns of a trial that the search varies.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "identification/quantity.h"
#include "identification/search.h"

namespace hystcan::identification {

/// One unknown, on a scale where a step of one is reasonable.
struct Unknown {
  Quantity quantity;
  double start = 0.0;
  double step = 0.5;
  std::function<void(Trial&, double)> set;
};

/// Returns the start values or the steps of the unknowns.
Eigen::VectorXd numbers_of(const std::vector<Unknown>& unknowns, double Unknown::*number);
/// Returns the trial with these values of the unknowns.
Trial moved_to(const Eigen::VectorXd& values, const std::vector<Unknown>& unknowns, Trial trial);

/// Returns the two unknowns k_ascending and k_descending.
std::vector<Unknown> both_k(const Trial& trial);
/// Returns an unknown: the bias of the initial memory of a dataset.
Unknown bias_of(std::size_t dataset, double start);
/// Returns an unknown: the delay in units of `unit_s`, starting at one unit.
Unknown delay_of(double unit_s);
/// Returns an unknown: the gain of a dataset relative to the first dataset.
Unknown gain_of(std::size_t dataset, double start);
/// Returns the unknowns that can be searched in addition to `used`.
std::vector<Unknown> candidates(const Trial& trial, const std::vector<Unknown>& used, const Problem& problem,
                                const IdentifyOptions& options);

}  // namespace hystcan::identification
