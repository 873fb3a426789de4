// An actuator as its model file states it: hysteresis of any kind, with creep and dynamics behind it; and its
// memory.
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

/// The rows of one pass.
struct Pass {
  std::vector<double> inputs;  ///< found for wanted outputs; empty where the inputs are given
  std::vector<double> outputs;
  model::Tally tally{};
};

/// Memory of the hysteresis, and of the creep behind it. Creep needs the times of inputs and outputs, which
/// increase.
class ActuatorMemory {
 public:
  static constexpr std::size_t capacity = 4096;  ///< branches

  /// The initial ascending curve, at the lower threshold. The creep is settled at the first row.
  ActuatorMemory(SharedModel model, const std::optional<model::OutputCreep::Config>& creep);
  /// Of a memory file, which has a creep if this has one. Throws Error.
  void load(const std::filesystem::path& file);
  /// Of the hysteresis alone, whatever creep the file has.
  void load_hysteresis(const std::filesystem::path& file);

  const SharedModel& model() const { return model_; }
  bool creeps() const { return creep_.has_value(); }
  double input() const;
  double output() const;
  std::optional<double> time_s() const;  ///< of the last row, if there is creep
  model::Interval reachable() const;
  std::vector<double> turning_inputs() const;  ///< oldest first; empty for play operators
  std::uint64_t merged() const;                ///< steps with a full memory
  std::string text() const;                    ///< TOML, as `simulate --save-memory` writes it

  /// `time_s`: as many as inputs or outputs; read only if there is creep.
  Pass simulate(std::span<const double> inputs, std::span<const double> time_s);
  /// `drive_sign`: of the inputs that are found; -1 makes sense only for an even model.
  Pass inverse(std::span<const double> outputs, std::span<const double> time_s, double drive_sign);

 private:
  double shown(double h) const;  // the output at present, if the hysteresis had the output h

  SharedModel model_;
  std::optional<model::HeldCreep> creep_;
  std::variant<model::HysteresisState, model::PlayState> state_;
};

struct Actuator {
  /// `beyond_limit`: also where branches do not all increase. Throws Error.
  static Actuator load(const std::filesystem::path& file, bool beyond_limit);
  static Actuator of(model::AnyModel model, std::string name, const identification::Lag& lag = {});

  /// The hysteresis alone, with its delay.
  Actuator quasi_static() const;
  ActuatorMemory memory() const { return {model, lag.creep}; }

  std::string kind() const;
  model::Interval input_range() const;
  bool is_even() const;

  SharedModel model;
  std::string name;  ///< of the file
  std::string input_unit, output_unit;
  identification::Lag lag{};  ///< that was identified with it
};

}  // namespace hystcan::config
