// A model's prediction for a dataset, sample by sample.
#pragma once

#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "identification/initial_memory.h"
#include "model/dynamics.h"
#include "model/held_creep.h"
#include "model/hysteresis.h"

namespace hystcan::identification {

struct ErrorNorms {
  double rms = 0.0;
  double max = 0.0;  ///< largest |error|

  /// Errors over the samples from `begin` on. Both vectors have the same length.
  static ErrorNorms of(const std::vector<double>& predicted, const std::vector<double>& measured,
                       std::size_t begin = 0);
};

/// max - min.
double span_of(const std::vector<double>& values);

/// What stands between the output of a model and the measured one.
struct Lag {
  double delay_s = 0.0;                       ///< of the input; its turning points are kept (excerpt.h)
  std::optional<model::Dynamics> dynamics{};  ///< with a delay of their own: delay_s is then not used
  std::optional<model::OutputCreep::Config> creep{};  ///< before them; it begins settled

  double delay() const { return dynamics ? dynamics->delay_s : delay_s; }
  void set_delay(double s) { (dynamics ? dynamics->delay_s : delay_s) = s; }
};

/// Output at each sample of `dataset`. `state` is the memory at the first input, and afterwards the memory at the last
/// one; `crept`: creep at the first sample, none: settled. Throws std::invalid_argument if there are dynamics and the dataset is not evenly sampled.
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            model::HysteresisState& state,
                            const std::optional<model::HeldCreep::State>& crept = {});
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            const InitialMemory& memory);

}  // namespace hystcan::identification
