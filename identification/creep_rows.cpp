#include "identification/creep_rows.h"

#include <cstddef>

namespace hystcan::identification {

std::vector<double> with_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                               std::vector<double> outputs,
                               const std::optional<model::HeldCreep::State>& start) {
  if (creep.lags() == 0) return outputs;
  model::HeldCreep rows(creep, start);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    rows.hold_until(time_s[i]);
    outputs[i] = rows.follow(outputs[i]);
  }
  return outputs;
}

std::vector<double> without_creep(const model::OutputCreep& creep, const std::vector<double>& time_s,
                                  std::vector<double> outputs, const std::vector<bool>& counts) {
  if (creep.lags() == 0) return outputs;
  model::HeldCreep rows(creep);
  double now_s = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (!counts.empty() && !counts[i]) continue;
    if (i > 0) now_s += time_s[i] - time_s[i - 1];
    rows.hold_until(now_s);
    outputs[i] = rows.inverse(outputs[i]);
    rows.follow(outputs[i]);
  }
  return outputs;
}

}  // namespace hystcan::identification
