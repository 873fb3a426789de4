// A model's prediction for a dataset, sample by sample, starting with the memory of the actuator at its
// beginning.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "model/dynamics.h"
#include "model/hysteresis.h"
#include "model/output_creep.h"

namespace hystcan::identification {

/// The memory of an actuator at the beginning of a dataset. It is unknown and is estimated from the dataset.
///
/// The dataset shows only how the earlier turning points were distributed around the first input v_0. They
/// are modelled as a decaying oscillation of N nested loops between the thresholds, with one parameter, the
/// bias b:
///
///   u_j = v_0 + (v_hi - v_0) (1 - j / (N + 1))^(e^b)
///   l_j = v_0 - (v_0 - v_lo) (1 - j / (N + 1))^(e^-b)
///
///   b = 0               demagnetised
///   b ->  infinity      arrived directly from the lower threshold
///   b -> -infinity      arrived directly from the upper threshold
///
/// In the Preisach plane the u_j, l_j are the staircase between the two half planes.
struct InitialMemory {
  enum class Kind { virgin, from_lower, from_upper, nested };
  Kind kind = Kind::virgin;
  double bias = 0.0;  ///< b, for `nested` only

  model::Origin origin() const;
};

/// True if one of these datasets begins on the ascending reference curve. In all others no sample is on it.
bool shows_ascending_curve(const std::vector<InitialMemory>& memories);

/// Returns the inputs that lead from the origin to `first`, without `first`; empty if the memory is virgin.
std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first);

/// Returns the same memory as a state of the model, at the input `first`.
model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first);

struct ErrorNorms {
  double rms = 0.0;
  double max = 0.0;  ///< largest |error|

  /// Computes the errors of the samples, starting at `begin`. Both vectors must have the same length.
  static ErrorNorms of(const std::vector<double>& predicted, const std::vector<double>& measured,
                       std::size_t begin = 0);
};

/// The links between the output of a model and the measured output.
struct Lag {
  double delay_s = 0.0;                       ///< delay of the input; its turning points are kept (excerpt.h)
  std::optional<model::Dynamics> dynamics{};  ///< with their own delay: delay_s is then ignored
  std::optional<model::OutputCreep::Config> creep{};  ///< creep before the dynamics, settled at the beginning

  double delay() const { return dynamics ? dynamics->delay_s : delay_s; }
  void set_delay(double s) { (dynamics ? dynamics->delay_s : delay_s) = s; }
};

/// Returns the output at each sample of `dataset`. `state` is the memory at the first input, and on return
/// the memory at the last one. `crept`: creep at the first sample; `nullopt`: settled. Throws
/// std::invalid_argument if there are dynamics and the dataset is not evenly sampled.
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            model::HysteresisState& state,
                            const std::optional<model::HeldCreep::State>& crept = {});
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            const InitialMemory& memory);

/// The error of a prediction at different speeds of the input.
struct RateError {
  double speed = 0.0;  ///< mean speed of the half cycles in this class, input units per second
  double rms = 0.0;    ///< output units
  std::size_t samples = 0;
};

/// Half cycles are divided into classes a factor of two wide, slowest first. A single class means that all
/// have about the same speed.
std::vector<RateError> errors_by_rate(const Dataset& dataset, const std::vector<double>& predicted);

/// The memory of an actuator at the beginning of a dataset, estimated with a model of the actuator.
struct MemoryEstimate {
  InitialMemory memory;
  double offset = 0.0;  ///< to be added to the model's output
  double rms = 0.0;     ///< error over the samples of the estimate, output units
};

/// Returns the memory and the offset with the smallest RMS error over the first `samples` samples. Without
/// `with_offset`, the offset is 0.
MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                               std::size_t samples, bool with_offset);

}  // namespace hystcan::identification
