// A model with what its file says beside its parameters.
#pragma once

#include <string>

#include "identification/prediction.h"
#include "python/any_model.h"

namespace hystcan::python {

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
