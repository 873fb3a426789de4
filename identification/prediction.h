// Predicts the output of an actuator for each sample of a dataset with a model. The prediction begins with
// the memory that the actuator had at the first sample.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "identification/dataset.h"
#include "model/dynamics.h"
#include "model/hysteresis.h"
#include "model/output_creep.h"

namespace hystcan::identification {

/// The memory of an actuator at the beginning of a dataset. It is not known and must be estimated from the
/// dataset.
///
/// A dataset shows only how the earlier turning points were distributed around its first input v_0. They are
/// modelled as a decaying oscillation of N nested loops, with turning points u_j above v_0 and l_j below it,
/// j = 1 .. N. v_lo and v_hi are the thresholds of the model (ends of its input range). The only parameter is
/// the bias b:
///
///   u_j = v_0 + (v_hi - v_0) (1 - j / (N + 1))^(e^b)
///   l_j = v_0 - (v_0 - v_lo) (1 - j / (N + 1))^(e^-b)
///
///   b = 0               demagnetised
///   b ->  infinity      arrived directly from the lower threshold
///   b -> -infinity      arrived directly from the upper threshold
///
/// In the Preisach plane, the points (u_j, l_j) are the corners of the staircase line between the relays that
/// are up and the relays that are down.
struct InitialMemory {
  enum class Kind { virgin, from_lower, from_upper, nested };
  Kind kind = Kind::virgin;
  /// Bias b of the nested loops in the formula of InitialMemory; used only for the kind `nested`.
  double bias = 0.0;

  model::Origin origin() const;
};

/// Returns true if one of these memories is virgin: its dataset begins on the ascending reference curve. In
/// other datasets, no sample is on this curve.
bool shows_ascending_curve(const std::vector<InitialMemory>& memories);

/// Returns the inputs that create this memory: they lead from its origin to `first`, the first input of the
/// dataset, which is not included. Empty for a memory without nested loops.
std::vector<double> prehistory(const InitialMemory& memory, model::Interval thresholds, double first);

/// Returns this memory as a state of the model, at the input `first`.
model::HysteresisState state_of(const model::Hysteresis& model, const InitialMemory& memory, double first);

struct ErrorNorms {
  double rms = 0.0;
  double max = 0.0;  ///< largest magnitude of an error, output units

  /// Computes the errors of the samples from index `begin` on. Both vectors must have the same length.
  static ErrorNorms of(const std::vector<double>& predicted, const std::vector<double>& measured,
                       std::size_t begin = 0);
};

/// The processes between the output of the hysteresis and the measured output: delay, creep and dynamics.
struct Lag {
  /// Delay of the input; the inputs of turning points stay exact (excerpt.h).
  double delay_s = 0.0;
  /// Mode with its own delay; if it is set, delay_s is ignored.
  std::optional<model::Dynamics> dynamics{};
  /// Creep: acts on the output of the hysteresis, before the dynamics. Without other information, the creep
  /// is settled at the first sample, as if the input had been constant for a very long time.
  std::optional<model::OutputCreep::Config> creep{};

  double delay() const { return dynamics ? dynamics->delay_s : delay_s; }
  void set_delay(double s) { (dynamics ? dynamics->delay_s : delay_s) = s; }
};

/// Returns the output that the model predicts for each sample of `dataset`. `state` is the memory at the
/// first input; on return, it is the memory at the last input. `crept` is the creep at the first sample;
/// `nullopt`: settled. Throws std::invalid_argument if `lag` has dynamics and the dataset is not evenly
/// sampled.
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            model::HysteresisState& state,
                            const std::optional<model::HeldCreep::State>& crept = {});
std::vector<double> predict(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                            const InitialMemory& memory);

/// The RMS error of a prediction in a class of similar speeds of the input.
struct RateError {
  /// Mean speed of the half cycles in this class, input units per second.
  double speed = 0.0;
  double rms = 0.0;  ///< RMS error of the samples in this class of speeds, output units
  std::size_t samples = 0;
};

/// Returns the error of a prediction for each class of speeds, slowest first. A class contains half cycles
/// whose speeds differ by at most a factor of two; half cycles below a twentieth of the input range do not
/// count. If all half cycles have about the same speed, there may be a single class.
std::vector<RateError> errors_by_rate(const Dataset& dataset, const std::vector<double>& predicted);

/// An estimate of the actuator's memory at the beginning of a dataset, made with a known model.
struct MemoryEstimate {
  InitialMemory memory;
  double offset = 0.0;  ///< constant to add to the model's output
  double rms = 0.0;     ///< RMS error over the samples from which the memory was estimated, output units
};

/// Returns the memory and the offset with the smallest RMS error over the first `samples` samples. If
/// `with_offset` is false, the offset is 0.
MemoryEstimate estimate_memory(const model::Hysteresis& model, const Dataset& dataset, const Lag& lag,
                               std::size_t samples, bool with_offset);

}  // namespace hystcan::identification
