// What stands behind the hysteresis in `simulate`: creep, then a mode. Both come from the model file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/command_line/row_files.h"
#include "model/dynamics.h"
#include "model/output_creep.h"

namespace hystcan::app {

/// [creep] of the model file, row by row: model/output_creep.h.
class SimulatedCreep {
 public:
  /// None if the model file has no [creep]. `memory`: empty if there is none. `h`: output of the hysteresis
  /// where the memory is. Throws Error, also if the rows are not timed.
  static std::optional<SimulatedCreep> load(const std::filesystem::path& model, std::filesystem::path input,
                                            std::filesystem::path memory, double h, const RowInput& rows);

  /// Throws Error if the row is not later than the row before.
  void hold_until(double time_s);
  double inverse(double x) const { return held_.inverse(x); }
  double follow(double h) { return held_.follow(h); }

  /// "creep of 2 % a decade from 10 ms to 3 s".
  std::string text() const;
  /// After the last row, for a memory file.
  std::string memory_text() const;

 private:
  SimulatedCreep(std::filesystem::path input, std::filesystem::path memory,
                 const model::OutputCreep::Config& config, double h);
  [[noreturn]] void refuse(double time_s) const;

  std::filesystem::path input_, memory_;
  model::OutputCreep::Config config_;
  model::HeldCreep held_;
  std::uint64_t rows_ = 0;
};

/// The positions of a stage whose model file has [dynamics], at an even rate.
class SimulatedMode {
 public:
  SimulatedMode(const std::filesystem::path& model, std::filesystem::path input);

  /// From the outputs of the block to positions.
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
