#include "python/model.h"

#include <string_view>
#include <type_traits>
#include <utility>

#include "config/files/memory_file.h"
#include "model/hysteresis_operator.h"

namespace hystcan::python {
namespace {

constexpr std::size_t capacity = 4096;  // branches, as in `simulate`

template <class State>
inline constexpr bool has_branches = std::is_same_v<State, model::HysteresisState>;

AnyState at_rest(const model::AnyModel& model) {
  return std::visit(
      [](const auto& each) -> AnyState {
        using State = typename std::decay_t<decltype(each)>::State;
        if constexpr (has_branches<State>)
          return each.virgin(each.input_range().lo, capacity);
        else
          return each.virgin(each.input_range().lo);
      },
      model);
}

/// Calls `work(model, state)` with the types that belong together.
template <class Any, class Work>
auto with(const model::AnyModel& model, Any& state, Work work) {
  return std::visit(
      [&](const auto& each) {
        using State = typename std::decay_t<decltype(each)>::State;
        return work(each, std::get<State>(state));
      },
      model);
}

template <class Model>
bool has_even_symmetry(const Model& model) {
  return model.symmetry() == model::Symmetry::even;
}
bool has_even_symmetry(const model::PrandtlIshlinskii&) { return false; }

}  // namespace

Memory::Memory(SharedModel model, const Creep& creep) : model_(std::move(model)), state_(at_rest(*model_)) {
  if (creep) creep_.emplace(model::OutputCreep(*creep));
}

Memory Memory::load(SharedModel model, const Creep& creep, const std::filesystem::path& file) {
  Memory memory(std::move(model), creep);
  memory.state_ =
      std::visit([&](const auto& each) -> AnyState { return config::load_memory(file, each, capacity); },
                 *memory.model_);
  const model::OutputCreep law(creep);
  const auto start = config::load_creep_memory(file, law, memory.output());
  if (creep) memory.creep_.emplace(law, start);
  return memory;
}

double Memory::input() const {
  return std::visit([](const auto& state) { return state.input; }, state_);
}

double Memory::shown(double h) const {
  return creep_ && creep_->state() ? creep_->creep().output(creep_->state()->creep, h) : h;
}

double Memory::output() const {
  return shown(std::visit([](const auto& state) { return state.output; }, state_));
}

std::optional<double> Memory::time_s() const {
  return creep_ && creep_->state() ? creep_->state()->time_s : std::nullopt;
}

model::Interval Memory::reachable() const {
  const model::Interval h =
      with(*model_, state_, [](const auto& model, const auto& state) { return model.reachable(state); });
  return {shown(h.lo), shown(h.hi)};
}

std::vector<double> Memory::turning_inputs() const {
  std::vector<double> inputs;
  if (const auto* const state = std::get_if<model::HysteresisState>(&state_))
    for (std::size_t i = 1; i < state->depth(); ++i) inputs.push_back(state->branches[i].start_input);
  return inputs;
}

std::string Memory::text() const {
  return with(*model_, state_, [&](const auto& model, const auto& state) {
    return config::memory_text(model, state) +
           (creep_ && creep_->state() ? config::creep_memory_text(*creep_->state()) : std::string());
  });
}

Pass Memory::simulate(std::span<const double> inputs, std::span<const double> time_s) {
  return with(*model_, state_, [&](const auto& model, auto& state) {
    Pass pass{std::vector<double>(inputs.size())};
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (creep_) creep_->hold_until(time_s[i]);
      const model::Prediction step = model.advance(state, inputs[i]);
      pass.values[i] = creep_ ? creep_->follow(state.output) : state.output;
      pass.tally.count(step);
    }
    return pass;
  });
}

Pass Memory::inverse(std::span<const double> outputs, std::span<const double> time_s, double drive_sign) {
  return with(*model_, state_, [&](const auto& model, auto& state) {
    model::Simulation simulation(model, state, drive_sign);
    std::vector<double> inputs(outputs.size());
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (creep_) creep_->hold_until(time_s[i]);
      const model::Row row = simulation.follow_output(creep_ ? creep_->inverse(outputs[i]) : outputs[i]);
      if (creep_) creep_->follow(row.output);
      inputs[i] = row.input;
    }
    state = simulation.state();
    return Pass{std::move(inputs), simulation.tally()};
  });
}

Model Model::load(const std::filesystem::path& file, bool beyond_limit) {
  Model model;
  model.model = std::make_shared<const model::AnyModel>(
      beyond_limit ? model::AnyModel(config::load_model_beyond_limit(file)) : config::load_any_model(file));
  model.name = file.filename().string();
  std::visit(
      [&](const auto& each) {
        model.input_unit = each.parameters().input_unit;
        model.output_unit = each.parameters().output_unit;
      },
      *model.model);
  model.lag = config::load_lag(file);
  return model;
}

Model Model::quasi_static() const {
  Model alone = *this;
  alone.model = std::make_shared<const model::AnyModel>(*model);  // its memories are others
  alone.lag = {.delay_s = lag.delay_s};
  return alone;
}

std::string Model::kind() const {
  return std::visit([](const auto& each) { return std::string(each.kind()); }, *model);
}

model::Interval Model::input_range() const {
  return std::visit([](const auto& each) { return each.input_range(); }, *model);
}

bool Model::is_even() const {
  return std::visit([](const auto& each) { return has_even_symmetry(each); }, *model);
}

}  // namespace hystcan::python
