// An actuator that a model file describes: its hysteresis model of any kind, followed by creep and dynamics.
// Also the actuator's memory, which depends on the past inputs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "config/files/model_file.h"
#include "identification/prediction.h"
#include "model/any_model.h"
#include "model/hysteresis_operator.h"
#include "model/output_creep.h"

namespace hystcan::config {

using SharedModel = std::shared_ptr<const model::AnyModel>;

/// The result of ActuatorMemory::simulate() or ActuatorMemory::inverse(). The lists have one value for each
/// input of simulate(), or for each requested output of inverse().
struct Pass {
  std::vector<double> inputs;  ///< result of inverse(): inputs for the requested outputs; else empty
  std::vector<double> outputs;
  model::Tally tally{};
};

/// The memory of an actuator: the state of its hysteresis, and of its creep if the model has creep. With
/// creep, each input needs a time, and the times must increase.
class ActuatorMemory {
 public:
  static constexpr std::size_t capacity = 4096;  ///< maximum number of hysteresis branches in the memory

  /// Starts at the lower end of the model's input range, on the initial ascending curve. The creep is assumed
  /// to have settled before the first input.
  ActuatorMemory(SharedModel model, const std::optional<model::OutputCreep::Config>& creep);
  /// Loads a memory file. If the file has no creep, the creep is settled at the first row. Throws Error if
  /// the file is invalid, belongs to another model, or has creep that this model does not have.
  void load(const std::filesystem::path& file);
  /// Loads only the hysteresis from a memory file and ignores creep in the file. Throws Error if the file is
  /// invalid or belongs to another model.
  void load_hysteresis(const std::filesystem::path& file);

  const SharedModel& model() const { return model_; }
  bool creeps() const { return creep_.has_value(); }
  double input() const;
  double output() const;
  /// Returns the time of the last input; nullopt if the model has no creep, or before the first input.
  std::optional<double> time_s() const;
  model::Interval reachable() const;
  /// Returns the inputs at the stored turning points, oldest first; empty for a model of play operators.
  std::vector<double> turning_inputs() const;
  std::uint64_t merged() const;  ///< number of steps in which the memory was full and merged branches
  std::string text() const;  ///< the content of a memory file (TOML), as `simulate --save-memory` writes it

  /// Computes the outputs for a series of inputs. `time_s` has the time of each input; it is only read if the
  /// actuator has creep.
  Pass simulate(std::span<const double> inputs, std::span<const double> time_s);
  /// Computes the inputs that give the requested outputs. `time_s` is as for simulate(). The function
  /// multiplies the inputs by `drive_sign`, 1 or -1. Use -1 only for a model with even symmetry, in which an
  /// input and its negative give the same output.
  Pass inverse(std::span<const double> outputs, std::span<const double> time_s, double drive_sign);

 private:
  double shown(double h) const;  // output of the actuator, creep included, for the hysteresis output h

  SharedModel model_;
  std::optional<model::HeldCreep> creep_;
  std::variant<model::HysteresisState, model::PlayState> state_;
};

struct Actuator {
  /// Loads a model file. Throws Error if the file is invalid. With `beyond_limit`, also accepts a model in
  /// which some branches do not increase, because a convergence rate k exceeds its limit.
  static Actuator load(const std::filesystem::path& file, bool beyond_limit);
  static Actuator of(model::AnyModel model, std::string name, const identification::Lag& lag = {});

  /// Returns a copy of the actuator that has only its hysteresis and its delay, but no creep and no dynamics.
  Actuator quasi_static() const;
  ActuatorMemory memory() const { return {model, lag.creep}; }

  std::string kind() const;
  model::Interval input_range() const;
  bool is_even() const;

  SharedModel model;
  std::string name;  ///< name of the model file
  std::string input_unit, output_unit;
  identification::Lag lag{};  ///< delay, dynamics and creep from the model file
};

}  // namespace hystcan::config
