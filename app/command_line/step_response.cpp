#include "app/command_line/step_response.h"

#include <algorithm>
#include <cmath>

namespace hystcan::app {
namespace {

constexpr std::size_t least_rest = 10;  // rows
constexpr double settled_within = 0.02;

std::size_t rest_after(std::span<const double> reference, std::size_t step) {
  std::size_t end = step;
  while (end < reference.size() && reference[end] == reference[step]) ++end;
  return end;
}

/// The row with the new value; 0 if there is none.
std::size_t largest_step(std::span<const double> reference) {
  const auto [low, high] = std::ranges::minmax(reference);
  std::size_t found = 0;
  double largest = 0.5 * (high - low);
  for (std::size_t i = 1; i < reference.size(); ++i) {
    const double change = std::abs(reference[i] - reference[i - 1]);
    if (!(change > 0.0) || change < largest || rest_after(reference, i) < i + least_rest) continue;
    found = i;
    largest = change;
  }
  return found;
}

}  // namespace

std::optional<StepResponse> step_response(std::span<const double> time_s, std::span<const double> reference,
                                          std::span<const double> position) {
  if (reference.size() <= least_rest) return std::nullopt;
  const std::size_t begin = largest_step(reference);
  if (begin == 0) return std::nullopt;
  StepResponse step{.begin = begin,
                    .end = rest_after(reference, begin),
                    .from = reference[begin - 1],
                    .to = reference[begin],
                    .rise_s = {},
                    .settled_s = {}};
  std::optional<double> at_10, at_90;
  for (std::size_t i = begin; i < step.end; ++i) {
    if (!std::isfinite(position[i])) continue;
    const double share = (position[i] - step.from) / (step.to - step.from);
    if (!at_10 && share >= 0.1) at_10 = time_s[i];
    if (!at_90 && share >= 0.9) at_90 = time_s[i];
    step.overshoot_percent = std::max(step.overshoot_percent, 100.0 * (share - 1.0));
    if (std::abs(share - 1.0) > settled_within)
      step.settled_s.reset();
    else if (!step.settled_s)
      step.settled_s = time_s[i] - time_s[begin];
  }
  if (at_10 && at_90) step.rise_s = *at_90 - *at_10;
  return step;
}

}  // namespace hystcan::app
