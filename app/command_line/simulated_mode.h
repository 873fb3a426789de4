// Simulates the mechanical mode (resonance) of a stage for `hystcan simulate --dynamics`. Its input is the
// output of hysteresis and creep.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/command_line/row_files.h"
#include "config/files/actuator.h"
#include "model/dynamics.h"

namespace hystcan::app {

/// Computes the position of a stage for each row of `hystcan simulate --dynamics`. The model file of the
/// stage must have the table [dynamics]. The time between two rows must be constant.
class SimulatedMode {
 public:
  /// Throws Error if the model `file` has no [dynamics]. `input`: name of the input file, for error messages.
  SimulatedMode(const config::Actuator& actuator, const std::filesystem::path& file,
                std::filesystem::path input);

  /// Replaces the values in the column `output` of the block. Before the call they are the output of
  /// hysteresis and creep; after the call they are the position of the stage, with its resonance and delay.
  void move(SampleBlock& block);

 private:
  double next(double time_s, double at_rest);
  [[noreturn]] void refuse(double step_s, const std::string& expected) const;

  std::filesystem::path input_;
  model::Dynamics dynamics_;
  std::optional<model::DynamicOutput> output_;
  std::uint64_t row_ = 0;
  double first_ = 0.0, before_s_ = 0.0, cycle_s_ = 0.0;
};

}  // namespace hystcan::app
