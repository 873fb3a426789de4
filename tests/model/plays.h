// Prandtl-Ishlinskii models and memories for the tests.
#pragma once

#include <vector>

#include "model/prandtl_ishlinskii.h"
#include "tests/model/models.h"

namespace hystcan::model {

// Up to 12 plays, with thresholds up to 1.2 of the range. The slopes W_i are between 0.05 and 1 of their
// scale in random order, so that half of the weights are negative.
inline PrandtlIshlinskiiParameters random_plays() {
  const auto plays = *rc::gen::inRange(0, 13);
  const double lo = *rc::gen::element(0.0, -1.0, 2.5, -50.0);
  const double span = *rc::gen::element(1.0, 3.0, 100.0, 1500.0);
  const double size = *rc::gen::element(1.0, 30.0, 1e-3);
  PrandtlIshlinskiiParameters p{"V", "um", {lo, lo + span}, 0.0, 0.0, {}, {}};
  p.offset = size * *rc::gen::element(0.0, 0.3, -2.0);
  p.gain = size / span * *number(0.05, 1.0);
  double threshold = 0.0, slope = p.gain;
  for (int i = 0; i < plays; ++i) {
    p.thresholds.push_back(threshold += span * *number(1e-4, 0.1));
    const double next = size / span * *number(0.05, 1.0);
    p.weights.push_back(next - slope);
    slope = next;
  }
  return p;
}

inline PlayState after(const PrandtlIshlinskii& model, const std::vector<double>& inputs) {
  PlayState state = model.virgin(inputs.front());
  for (const double v : inputs) model.advance(state, v);
  return state;
}

inline PlayState random_state(const PrandtlIshlinskii& model) {
  return after(model, random_walk(model.input_range(), *rc::gen::inRange(1, 30)));
}

}  // namespace hystcan::model
