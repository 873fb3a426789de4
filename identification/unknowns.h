// The unknowns that a search varies, and functions that write their values into a trial.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "identification/quantity.h"
#include "identification/search.h"

namespace hystcan::identification {

/// One unknown of a search. It is scaled so that a change by one is a reasonable step: for example, the
/// logarithm of a gain. `set` converts a value of this scale and stores it in a trial.
struct Unknown {
  Quantity quantity;
  double start = 0.0;
  double step = 0.5;
  std::function<void(Trial&, double)> set;
};

/// Returns one number of each unknown: `number` is &Unknown::start or &Unknown::step.
Eigen::VectorXd numbers_of(const std::vector<Unknown>& unknowns, double Unknown::*number);
/// Returns the trial after each unknown got its element of `values`.
Trial moved_to(const Eigen::VectorXd& values, const std::vector<Unknown>& unknowns, Trial trial);

/// Returns two unknowns: the convergence rates of rising and of falling branches (k_ascending, k_descending).
/// They start at their values in the trial.
std::vector<Unknown> both_k(const Trial& trial);
/// Returns the bias of a dataset's initial memory (InitialMemory::bias) as an unknown that starts at `start`.
Unknown bias_of(std::size_t dataset, double start);
/// Returns the delay, divided by `unit_s`, as an unknown that starts at 1.
Unknown delay_of(double unit_s);
/// Returns the gain of a dataset, relative to the first dataset, as an unknown that starts at the gain
/// `start`.
Unknown gain_of(std::size_t dataset, double start);
/// Returns the unknowns that a search may add to the unknowns `used`: initial memories, thresholds, gains,
/// delay and creep. Leaves out those that `options` or `problem` fixes.
std::vector<Unknown> candidates(const Trial& trial, const std::vector<Unknown>& used, const Problem& problem,
                                const IdentifyOptions& options);

}  // namespace hystcan::identification
