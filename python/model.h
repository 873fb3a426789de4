// A model of any kind with what its file says beside its parameters, and its memory, as Python holds them.
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

namespace hystcan::python {

using SharedModel = std::shared_ptr<const model::AnyModel>;
using AnyState = std::variant<model::HysteresisState, model::PlayState>;

/// What the rows of one pass had.
struct Pass {
  std::vector<double> values;
  model::Tally tally{};
};

/// Of a model, and of the creep behind it. Creep needs the times of inputs and outputs, which increase.
class Memory {
 public:
  using Creep = std::optional<model::OutputCreep::Config>;

  /// The initial ascending curve, at the lower threshold. The creep is settled at the first row.
  Memory(SharedModel model, const Creep& creep);
  static Memory load(SharedModel model, const Creep& creep, const std::filesystem::path& file);

  const SharedModel& model() const { return model_; }
  bool creeps() const { return creep_.has_value(); }
  double input() const;
  double output() const;
  std::optional<double> time_s() const;  ///< of the last row, if there is creep
  model::Interval reachable() const;
  std::vector<double> turning_inputs() const;  ///< oldest first; empty for play operators
  std::string text() const;                    ///< TOML, as `simulate --save-memory` writes it

  /// `time_s`: as many as inputs or outputs; read only if there is creep.
  Pass simulate(std::span<const double> inputs, std::span<const double> time_s);
  Pass inverse(std::span<const double> outputs, std::span<const double> time_s, double drive_sign);

 private:
  double shown(double h) const;  // the output at present, if the hysteresis had the output h

  SharedModel model_;
  std::optional<model::HeldCreep> creep_;
  AnyState state_;
};

class Model {
 public:
  static Model load(const std::filesystem::path& file, bool beyond_limit);

  /// The hysteresis alone, with its delay.
  Model quasi_static() const;
  Memory memory() const { return {model, lag.creep}; }

  std::string kind() const;
  model::Interval input_range() const;
  bool is_even() const;

  SharedModel model;
  std::string name;  ///< of the file
  std::string input_unit, output_unit;
  identification::Lag lag{};  ///< that was identified with it
};

}  // namespace hystcan::python
