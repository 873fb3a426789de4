#include "model/simulation.h"

namespace hystcan::model {

Simulation::Simulation(const Hysteresis& model, std::size_t capacity)
    : model_(model), state_(model.virgin(model.input_range().lo, capacity)) {}

Simulation::Row Simulation::follow_input(double input) {
  count(model_.advance(state_, input));
  return {input, state_.output};
}

Simulation::Row Simulation::follow_output(double output) {
  const Prediction drive = model_.inverse(state_, output);
  model_.advance(state_, drive.value);
  count(drive);
  return {state_.input, state_.output};
}

void Simulation::count(const Prediction& step) {
  ++tally_.rows;
  if (step.saturated) ++tally_.saturated;
  if (!step.increasing) ++tally_.not_increasing;
}

}  // namespace hystcan::model
