#include "app/command_line/simulated_mode.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/error.h"

namespace hystcan::app {

SimulatedMode::SimulatedMode(const config::Actuator& actuator, const std::filesystem::path& file,
                             std::filesystem::path input)
    : input_(std::move(input)) {
  if (!actuator.lag.dynamics)
    throw Error(file, "has no [dynamics]",
                {.expected = "this table with --dynamics",
                 .remedy = "identify the dynamics with `hystcan identify --dynamics`"});
  dynamics_ = *actuator.lag.dynamics;
}

void SimulatedMode::move(SampleBlock& block) {
  for (std::size_t i = 0; i < block.output.size(); ++i, ++row_)
    block.output[i] = next(block.time_s[i], block.output[i]);
}

// Returns the position of the stage in the next row. `at_rest`: output of hysteresis and creep in this row,
// the position at which the stage would come to rest. In the first row the stage is at rest. The time between
// the first two rows is used as the cycle time.
double SimulatedMode::next(double time_s, double at_rest) {
  if (row_ == 0) {
    first_ = at_rest;
    before_s_ = time_s;
    return at_rest;
  }
  const double step_s = time_s - before_s_;
  before_s_ = time_s;
  if (!output_) {
    if (!(step_s > 0.0)) refuse(step_s, "a positive step");
    cycle_s_ = step_s;
    output_.emplace(dynamics_, cycle_s_, first_);
    output_->advance(first_);
  }
  if (!(std::abs(step_s - cycle_s_) <= 0.01 * cycle_s_))
    refuse(step_s, fmt::format("{:g} s within 1 %", cycle_s_));
  return output_->advance(at_rest);
}

void SimulatedMode::refuse(double step_s, const std::string& expected) const {
  throw Error(input_, fmt::format("row {} is {:g} s after the row before", row_ + 1, step_s),
              expect("{}: --dynamics needs rows at equal intervals", expected));
}

}  // namespace hystcan::app
