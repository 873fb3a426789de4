// A model of any kind and its memory, as Python holds them.
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
#include "model/any_model.h"
#include "model/held_creep.h"

namespace hystcan::python {

using SharedModel = std::shared_ptr<const model::AnyModel>;
using AnyState = std::variant<model::HysteresisState, model::PlayState>;

/// What the rows of one pass had.
struct Pass {
  std::vector<double> values;
  std::size_t saturated = 0;       ///< limited to what can be reached
  std::size_t not_increasing = 0;  ///< on a branch that does not increase
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

}  // namespace hystcan::python
