#include "config/files/actuator.h"

#include <utility>

#include "config/files/memory_file.h"

namespace hystcan::config {
namespace {

template <class Model>
typename Model::State at_rest(const Model& model) {
  if constexpr (requires { model.virgin(0.0, ActuatorMemory::capacity); })
    return model.virgin(model.input_range().lo, ActuatorMemory::capacity);
  else
    return model.virgin(model.input_range().lo);
}

/// Returns the result of work(M, S). M is the model that the variant `model` contains. S is its state: the
/// variant `state` must contain the State type of M.
template <class Any, class Work>
auto with(const model::AnyModel& model, Any& state, Work work) {
  return std::visit(
      [&](const auto& each) {
        using State = typename std::decay_t<decltype(each)>::State;
        return work(each, std::get<State>(state));
      },
      model);
}

}  // namespace

ActuatorMemory::ActuatorMemory(SharedModel model, const std::optional<model::OutputCreep::Config>& creep)
    : model_(std::move(model)),
      state_(std::visit([](const auto& each) { return decltype(state_)(at_rest(each)); }, *model_)) {
  if (creep) creep_.emplace(model::OutputCreep(*creep));
}

void ActuatorMemory::load_hysteresis(const std::filesystem::path& file) {
  std::visit([&](const auto& each) { state_ = load_memory(file, each, capacity); }, *model_);
}

void ActuatorMemory::load(const std::filesystem::path& file) {
  load_hysteresis(file);
  const model::OutputCreep law = creep_ ? creep_->creep() : model::OutputCreep();
  const double h = std::visit([](const auto& state) { return state.output; }, state_);
  const auto start = load_creep_memory(file, law, h);
  if (creep_) creep_.emplace(law, start);
}

double ActuatorMemory::input() const {
  return std::visit([](const auto& state) { return state.input; }, state_);
}

double ActuatorMemory::shown(double h) const {
  return creep_ && creep_->state() ? creep_->creep().output(creep_->state()->creep, h) : h;
}

double ActuatorMemory::output() const {
  return shown(std::visit([](const auto& state) { return state.output; }, state_));
}

std::optional<double> ActuatorMemory::time_s() const {
  return creep_ && creep_->state() ? creep_->state()->time_s : std::nullopt;
}

model::Interval ActuatorMemory::reachable() const {
  const model::Interval h =
      with(*model_, state_, [](const auto& model, const auto& state) { return model.reachable(state); });
  return {shown(h.lo), shown(h.hi)};
}

std::vector<double> ActuatorMemory::turning_inputs() const {
  std::vector<double> inputs;
  if (const auto* const state = std::get_if<model::HysteresisState>(&state_))
    for (std::size_t i = 1; i < state->depth(); ++i) inputs.push_back(state->branches[i].start_input);
  return inputs;
}

std::uint64_t ActuatorMemory::merged() const {
  const auto* const state = std::get_if<model::HysteresisState>(&state_);
  return state != nullptr ? state->merged : 0;
}

std::string ActuatorMemory::text() const {
  return with(*model_, state_, [&](const auto& model, const auto& state) {
    return memory_text(model, state) +
           (creep_ && creep_->state() ? creep_memory_text(*creep_->state()) : std::string());
  });
}

Pass ActuatorMemory::simulate(std::span<const double> inputs, std::span<const double> time_s) {
  return with(*model_, state_, [&](const auto& model, auto& state) {
    Pass pass{.inputs = {}, .outputs = std::vector<double>(inputs.size())};
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      if (creep_) creep_->hold_until(time_s[i]);
      pass.tally.count(model.advance(state, inputs[i]));
      pass.outputs[i] = creep_ ? creep_->follow(state.output) : state.output;
    }
    return pass;
  });
}

Pass ActuatorMemory::inverse(std::span<const double> outputs, std::span<const double> time_s,
                             double drive_sign) {
  return with(*model_, state_, [&](const auto& model, auto& state) {
    Pass pass{.inputs = std::vector<double>(outputs.size()), .outputs = std::vector<double>(outputs.size())};
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (creep_) creep_->hold_until(time_s[i]);
      const auto drive = model.inverse(state, creep_ ? creep_->inverse(outputs[i]) : outputs[i]);
      model.advance(state, drive);
      pass.tally.count(drive);
      pass.inputs[i] = drive_sign * state.input;
      pass.outputs[i] = creep_ ? creep_->follow(state.output) : state.output;
    }
    return pass;
  });
}

Actuator Actuator::of(model::AnyModel model, std::string name, const identification::Lag& lag) {
  Actuator actuator{.model = std::make_shared<const model::AnyModel>(std::move(model)),
                    .name = std::move(name),
                    .input_unit = {},
                    .output_unit = {},
                    .lag = lag};
  std::visit(
      [&](const auto& each) {
        actuator.input_unit = each.parameters().input_unit;
        actuator.output_unit = each.parameters().output_unit;
      },
      *actuator.model);
  return actuator;
}

Actuator Actuator::load(const std::filesystem::path& file, bool beyond_limit) {
  return of(beyond_limit ? model::AnyModel(load_model_beyond_limit(file)) : load_any_model(file),
            file.filename().string(), load_lag(file));
}

Actuator Actuator::quasi_static() const {
  Actuator hysteresis_only = *this;
  // A caller refuses a memory if its model is not the same object as the model of the actuator. The copied
  // model is another object. So a memory of this actuator, which may contain creep, is refused for the
  // actuator without creep.
  hysteresis_only.model = std::make_shared<const model::AnyModel>(*model);
  hysteresis_only.lag = {.delay_s = lag.delay_s};
  return hysteresis_only;
}

std::string Actuator::kind() const {
  return std::visit([](const auto& each) { return std::string(each.kind()); }, *model);
}

model::Interval Actuator::input_range() const {
  return std::visit([](const auto& each) { return each.input_range(); }, *model);
}

bool Actuator::is_even() const {
  return std::visit([](const auto& each) { return model::is_even(each); }, *model);
}

}  // namespace hystcan::config
