// The response to the largest step of a reference.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace hystcan::app {

struct StepResponse {
  std::size_t begin = 0,
              end = 0;  ///< rows: of the step, and behind the last one before the reference moves again
  double from = 0.0, to = 0.0;      ///< values of the reference
  std::optional<double> rise_s;     ///< from 10 to 90 % of the step
  double overshoot_percent = 0.0;   ///< of the step, beyond its end
  std::optional<double> settled_s;  ///< from then on within 2 % of the step; empty: never
};

/// A step is a change within one row that is at least half of all that the reference moves, and after which it rests for
/// ten rows or more. Spans of equal length. Empty: there is none.
std::optional<StepResponse> step_response(std::span<const double> time_s, std::span<const double> reference,
                                          std::span<const double> position);

}  // namespace hystcan::app
