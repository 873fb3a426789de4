// A model of any kind and its memory, as Python holds them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "config/files/model_file.h"
#include "model/any_model.h"

namespace hystcan::python {

using SharedModel = std::shared_ptr<const model::AnyModel>;
using AnyState = std::variant<model::HysteresisState, model::PlayState>;

/// What the rows of one pass had.
struct Pass {
  std::vector<double> values;
  std::size_t saturated = 0;       ///< limited to what can be reached
  std::size_t not_increasing = 0;  ///< on a branch that does not increase
};

class Memory {
 public:
  explicit Memory(SharedModel model);  ///< the initial ascending curve, at the lower threshold
  static Memory load(SharedModel model, const std::filesystem::path& file);

  const SharedModel& model() const { return model_; }
  double input() const;
  double output() const;
  model::Interval reachable() const;
  std::vector<double> turning_inputs() const;  ///< oldest first; empty for play operators
  std::string text() const;                    ///< TOML, as `simulate --save-memory` writes it

  double step(double input);
  Pass simulate(std::span<const double> inputs);
  Pass inverse(std::span<const double> outputs, double drive_sign);

 private:
  SharedModel model_;
  AnyState state_;
};

}  // namespace hystcan::python
