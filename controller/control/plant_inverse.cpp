#include "controller/control/plant_inverse.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::controller {

bool ReferenceWindow::continues(double t_s, double cycle_s) const {
  constexpr double on_time = 0.25;  // tolerance of the time between two calls, as a share of a cycle
  return filled_ && std::abs(t_s - last_s_ - cycle_s) < on_time * cycle_s;
}

void ReferenceWindow::push(double value) {
  values_[oldest_] = values_[oldest_ + std::tuple_size_v<FeedForwardWeights>] = value;
  oldest_ = (oldest_ + 1) % std::tuple_size_v<FeedForwardWeights>;
}

double PlantRecursion::step(const Config& config, State& state, double input) {
  const double u = Notch::step(config.notch, state.notch, input);
  const double before = std::exchange(state.input, u), difference = u - before;
  const double difference_before = std::exchange(state.difference, difference);
  const double driven = config.interpolated ? difference - difference_before : difference;
  double y = config.interpolated ? before + config.constant * difference : u;
  for (std::size_t i = 0; i < config.terms.size(); ++i) {
    state.terms[i] = config.terms[i].decay * state.terms[i] + config.terms[i].share * driven;
    y += state.terms[i].real();
  }
  return y;
}

void PlantInverse::restart(double rest_until_s) {
  ahead_.clear();
  late_.clear();
  rest_until_s_ = rest_until_s;
  is_running_ = false;
}

void PlantInverse::retune(const Config& config) {
  config_ = config;
  restart(-std::numeric_limits<double>::infinity());
}

int PlantInverse::cycles_since_rest(double late_s, double cycle_s) const {
  const double cycles = std::ceil((late_s - rest_until_s_) / cycle_s) + feed_forward_reach + 1.0;
  return static_cast<int>(std::clamp(cycles, 1.0, warm_up_cycles));
}

}  // namespace hystcan::controller
