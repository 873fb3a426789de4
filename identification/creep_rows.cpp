#include "identification/creep_rows.h"

#include <cstddef>
#include <optional>

namespace hystcan::identification {

std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs) {
  if (creep.lags() == 0 || outputs.empty()) return outputs;
  model::OutputCreep::State state = creep.settled(outputs.front());
  double held = outputs.front();
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (i > 0) creep.advance(state, held, time_s[i] - time_s[i - 1]);
    held = outputs[i];
    outputs[i] = creep.output(state, held);
  }
  return outputs;
}

std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts) {
  if (creep.lags() == 0) return outputs;
  std::optional<model::OutputCreep::State> state;
  double held = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (!counts.empty() && !counts[i]) continue;
    if (!state)
      state = creep.settled(outputs[i]);
    else
      creep.advance(*state, held, time_s[i] - time_s[i - 1]);
    held = outputs[i] = creep.inverse(*state, outputs[i]);
  }
  return outputs;
}

}  // namespace hystcan::identification
