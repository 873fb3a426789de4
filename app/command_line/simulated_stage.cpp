#include "app/command_line/simulated_stage.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "app/stage/identification_result.h"
#include "base/error.h"
#include "config/files/memory_file.h"
#include "config/files/model_file.h"

namespace hystcan::app {
namespace {

model::Dynamics dynamics_of(const std::filesystem::path& model) {
  const std::optional<model::Dynamics> dynamics = config::load_lag(model).dynamics;
  if (!dynamics)
    throw Error(
        fmt::format("{}: has no [dynamics], expected that table with --dynamics; `hystcan identify "
                    "--dynamics` finds it",
                    model.string()));
  return *dynamics;
}

}  // namespace

std::optional<SimulatedCreep> SimulatedCreep::load(const std::filesystem::path& model,
                                                   std::filesystem::path input, std::filesystem::path memory,
                                                   double h, const RowInput& rows) {
  const std::optional<model::OutputCreep::Config> config = config::load_lag(model).creep;
  if (config && !rows.timed())
    throw Error(
        fmt::format("{}: has no column time_s, expected one, because {} has [creep]; --quasi-static "
                    "leaves the creep out",
                    input.string(), model.string()));
  if (config) return SimulatedCreep(std::move(input), std::move(memory), *config, h);
  if (!memory.empty()) config::load_creep_memory(memory, model::OutputCreep(), h);  // has none, either
  return std::nullopt;
}

SimulatedCreep::SimulatedCreep(std::filesystem::path input, std::filesystem::path memory,
                               const model::OutputCreep::Config& config, double h)
    : input_(std::move(input)),
      memory_(std::move(memory)),
      config_(config),
      held_(model::OutputCreep(config),
            memory_.empty() ? std::nullopt
                            : config::load_creep_memory(memory_, model::OutputCreep(config), h)) {}

void SimulatedCreep::hold_until(double time_s) {
  if (const auto& state = held_.state(); state && state->time_s && !(time_s > *state->time_s)) refuse(time_s);
  held_.hold_until(time_s);
  ++rows_;
}

void SimulatedCreep::refuse(double time_s) const {
  const double before_s = *held_.state()->time_s;
  if (rows_ == 0)
    throw Error(
        fmt::format("{}: the first row is at {} s, expected more than {} s, time_s of {}; a memory "
                    "without time_s is that of the first row",
                    input_.string(), time_s, before_s, memory_.string()));
  throw Error(
      fmt::format("{}: row {} is at {} s, expected more than {} s, the time of the row before: "
                  "with [creep] a row lasts until the next one",
                  input_.string(), rows_ + 1, time_s, before_s));
}

std::string SimulatedCreep::text() const { return creep_text(config_); }

std::string SimulatedCreep::memory_text() const {
  return held_.state() ? config::creep_memory_text(*held_.state()) : "";
}

SimulatedMode::SimulatedMode(const std::filesystem::path& model, std::filesystem::path input)
    : input_(std::move(input)), dynamics_(dynamics_of(model)) {}

void SimulatedMode::move(SampleBlock& block) {
  for (std::size_t i = 0; i < block.output.size(); ++i, ++row_)
    block.output[i] = next(block.time_s[i], block.output[i]);
}

// The cycle is known with the second row. At the first one the stage is at rest.
double SimulatedMode::next(double time_s, double at_rest) {
  if (row_ == 0) {
    first_ = at_rest;
    before_s_ = time_s;
    return at_rest;
  }
  const double step_s = time_s - before_s_;
  before_s_ = time_s;
  if (!output_) {
    if (!(step_s > 0.0)) refuse(step_s, "a positive step");
    cycle_s_ = step_s;
    output_.emplace(dynamics_, cycle_s_, first_);
    output_->advance(first_);
  }
  if (!(std::abs(step_s - cycle_s_) <= 0.01 * cycle_s_))
    refuse(step_s, fmt::format("{:g} s within 1 %", cycle_s_));
  return output_->advance(at_rest);
}

void SimulatedMode::refuse(double step_s, const std::string& expected) const {
  throw Error(
      fmt::format("{}: row {} is {:g} s after the row before, expected {}: --dynamics needs an even rate",
                  input_.string(), row_ + 1, step_s, expected));
}

}  // namespace hystcan::app
