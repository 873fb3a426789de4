// What an actuator remembered when a dataset began, as far as the dataset and a model of it can tell.
#pragma once

#include <cstddef>

#include "identification/dataset.h"
#include "identification/initial_memory.h"

namespace hystcan::identification {

struct MemoryEstimate {
  InitialMemory memory;
  double offset = 0.0;  ///< to be added to the model's output
  double rms = 0.0;     ///< over the samples it was estimated from, output units
};

/// From the first `samples` samples: the memory and the offset that the least is missed with. The input is
/// delayed by `delay_s`. `with_offset`: false, and the offset is 0.
MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, double delay_s,
                               std::size_t samples, bool with_offset);

}  // namespace hystcan::identification
