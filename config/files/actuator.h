// An actuator as described by its model file: hysteresis of any kind, then creep, then dynamics. Also its
// memory of the past inputs.
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

/// The result of one pass over a file's rows.
struct Pass {
  std::vector<double> inputs;  ///< inputs that give the wanted outputs; empty if the inputs were given
  std::vector<double> outputs;
  model::Tally tally{};
};

/// The memory of the hysteresis, and of the creep after it. With creep, the rows need times, which must
/// increase.
class ActuatorMemory {
 public:
  static constexpr std::size_t capacity = 4096;  ///< maximum number of branches

  /// Starts on the initial ascending curve, at the lower threshold. The creep is settled at the first row.
  ActuatorMemory(SharedModel model, const std::optional<model::OutputCreep::Config>& creep);
  /// Loads a memory file, which must contain creep if this memory has creep. Throws Error.
  void load(const std::filesystem::path& file);
  /// Loads only the hysteresis; ignores any creep in the file.
  void load_hysteresis(const std::filesystem::path& file);

  const SharedModel& model() const { return model_; }
  bool creeps() const { return creep_.has_value(); }
  double input() const;
  double output() const;
  std::optional<double> time_s() const;  ///< time of the last row, if there is creep
  model::Interval reachable() const;
  std::vector<double> turning_inputs() const;  ///< inputs at the turning points, oldest first; empty for
                                               ///< play operators
  std::uint64_t merged() const;                ///< number of steps in which a full memory merged branches
  std::string text() const;                    ///< the memory as TOML, as written by `simulate --save-memory`

  /// `time_s`: one value for each input or output; only read if there is creep.
  Pass simulate(std::span<const double> inputs, std::span<const double> time_s);
  /// `drive_sign`: sign of the inputs to find; -1 is only useful for an even model.
  Pass inverse(std::span<const double> outputs, std::span<const double> time_s, double drive_sign);

 private:
  double shown(double h) const;  // present output, creep included, if the hysteresis had the output h

  SharedModel model_;
  std::optional<model::HeldCreep> creep_;
  std::variant<model::HysteresisState, model::PlayState> state_;
};

struct Actuator {
  /// `beyond_limit`: also accepts a model in which some branches do not increase. Throws Error.
  static Actuator load(const std::filesystem::path& file, bool beyond_limit);
  static Actuator of(model::AnyModel model, std::string name, const identification::Lag& lag = {});

  /// Returns only the hysteresis, with its delay.
  Actuator quasi_static() const;
  ActuatorMemory memory() const { return {model, lag.creep}; }

  std::string kind() const;
  model::Interval input_range() const;
  bool is_even() const;

  SharedModel model;
  std::string name;  ///< name in the file
  std::string input_unit, output_unit;
  identification::Lag lag{};  ///< delay, dynamics and creep identified with the model
};

}  // namespace hystcan::config
