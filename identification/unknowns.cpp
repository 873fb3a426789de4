#include "identification/unknowns.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::identification {

Eigen::VectorXd numbers_of(const std::vector<Unknown>& unknowns, double Unknown::*number) {
  Eigen::VectorXd numbers(std::ssize(unknowns));
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    numbers[static_cast<Eigen::Index>(i)] = unknowns[i].*number;
  return numbers;
}

Trial moved_to(const Eigen::VectorXd& values, const std::vector<Unknown>& unknowns, Trial trial) {
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    unknowns[i].set(trial, values[static_cast<Eigen::Index>(i)]);
  return trial;
}

std::vector<Unknown> both_k(const Trial& trial) {
  return {
      {{Quantity::Kind::k_ascending},
       std::asinh(trial.k_span_ascending),
       0.7,
       [](Trial& moved, double x) { moved.k_span_ascending = std::sinh(x); }},
      {{Quantity::Kind::k_descending}, std::asinh(trial.k_span_descending), 0.7, [](Trial& moved, double x) {
         moved.k_span_descending = std::sinh(x);
       }}};
}

Unknown bias_of(std::size_t dataset, double start) {
  return {{Quantity::Kind::initial_memory, dataset}, start, 0.7, [dataset](Trial& trial, double x) {
            trial.memories[dataset] = {InitialMemory::Kind::nested, std::clamp(x, -6.0, 6.0)};
          }};
}

Unknown delay_of(double unit_s) {
  return {
      {Quantity::Kind::delay}, 1.0, 1.0, [unit_s](Trial& moved, double x) { moved.delay_s = x * unit_s; }};
}

Unknown gain_of(std::size_t dataset, double start) {
  constexpr double unit = 0.1;
  return {{Quantity::Kind::gain, dataset}, std::log(start) / unit, 0.2, [dataset](Trial& trial, double x) {
            trial.gains.resize(trial.memories.size(), 1.0);
            trial.gains[dataset] = std::exp(unit * std::clamp(x, -5.0, 5.0));
          }};
}

std::vector<Unknown> candidates(const Trial& trial, const std::vector<Unknown>& used, const Problem& problem,
                                const IdentifyOptions& options) {
  using Kind = InitialMemory::Kind;
  std::vector<Unknown> candidates;
  const auto is_used = [&](const Quantity& quantity) {
    return std::ranges::find(used, quantity, &Unknown::quantity) != used.end();
  };
  for (std::size_t i = 0; i < trial.memories.size(); ++i) {
    const Kind kind = trial.memories[i].kind;
    if (kind != Kind::nested)
      candidates.push_back(bias_of(i, kind == Kind::from_lower   ? 1.0
                                      : kind == Kind::from_upper ? -1.0
                                                                 : 0.0));
  }
  const bool extends = !options.observed_thresholds;
  if (extends && !is_used({Quantity::Kind::lower_threshold}) && problem.symmetry == model::Symmetry::none)
    candidates.push_back({{Quantity::Kind::lower_threshold}, std::log(0.1), 0.7, [](Trial& moved, double x) {
                            moved.below = std::exp(x);
                          }});
  if (extends && !is_used({Quantity::Kind::upper_threshold}))
    candidates.push_back({{Quantity::Kind::upper_threshold}, std::log(0.05), 0.7, [](Trial& moved, double x) {
                            moved.above = std::exp(x);
                          }});
  for (std::size_t i = 1; !options.common_gain && i < trial.memories.size(); ++i)
    if (Unknown gain = gain_of(i, 1.0); !is_used(gain.quantity)) candidates.push_back(std::move(gain));
  if (!is_used({Quantity::Kind::delay}) && !options.delay_s && problem.sample_time_s > 0.0)
    candidates.push_back(delay_of(problem.sample_time_s));
  if (!is_used({Quantity::Kind::creep}) && !options.creep_per_decade)
    candidates.push_back({{Quantity::Kind::creep}, 1.0, 1.0, [](Trial& moved, double x) {
                            moved.creep_per_decade = 0.01 * x;
                          }});
  return candidates;
}

}  // namespace hystcan::identification
