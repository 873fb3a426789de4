#include "python/virtual_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "app/live/rehearsal_setup.h"
#include "base/error.h"

namespace hystcan::python {
namespace {

constexpr auto piece = std::chrono::milliseconds(500);
constexpr double start_up_limit_s = 60.0;  // longer than any start-up

can::Duration duration_of(double time_s) {
  return std::chrono::ceil<can::Duration>(std::chrono::duration<double>(time_s));
}

config::Config configuration(const std::filesystem::path& file, const std::vector<config::Setting>& overrides,
                             const std::map<std::string, controller::MonotoneCubic>& references) {
  config::Config config = config::load(file, overrides);
  for (const auto& [name, curve] : references) {
    const auto axis =
        std::ranges::find_if(config.axes, [&](const auto& each) { return each.wire.name == name; });
    if (axis == config.axes.end())
      throw Error(fmt::format("{}: no axis {}, which a reference is given for", file.string(), name));
    const controller::MotionBounds range = curve.bounds();
    const auto& supervision = axis->control.supervision;
    if (range.lowest_um < supervision.position_min_um || range.highest_um > supervision.position_max_um)
      throw Error(fmt::format("the reference of {} goes from {:g} to {:g} um, expected {:g} to {:g} um", name,
                              range.lowest_um, range.highest_um, supervision.position_min_um,
                              supervision.position_max_um));
    axis->control.setpoint.assign(1, {.shape = controller::Table{.file = "reference", .curve = curve}});
    axis->control.repeat = false;
  }
  return config;
}

}  // namespace

VirtualStage::VirtualStage(const std::filesystem::path& config, const std::vector<config::Setting>& overrides,
                           const std::map<std::string, controller::MonotoneCubic>& references)
    : config_(configuration(config, overrides, references)),
      live_(config, config_),
      columns_(config_.axes.size(), std::vector<std::vector<double>>(controller::cycle_columns().size() + 1)),
      true_um_(config_.axes.size()),
      tracks_since_s_(config_.axes.size()),
      loop_(std::make_unique<rehearsal::Rehearsal>(
          app::rehearsal_setup(config_), [this](const controller::CycleRecord& record) { take(record); })) {
  for (const config::AxisConfig& axis : config_.axes)
    lengths_s_.push_back(controller::reference_of(axis.control).length_s());
  loop_->controller().listen_to(requests_);
  loop_->twin().on_truth([this](const twin::Truth& truth) { true_um_.at(truth.axis) = truth.position_um; });
  loop_->start();
}

double VirtualStage::time_s() { return can::seconds(loop_->clock().now().time_since_epoch()); }

void VirtualStage::take(const controller::CycleRecord& record) {
  auto& columns = columns_[record.axis];
  std::size_t i = 0;
  for (const controller::CycleColumn& column : controller::cycle_columns())
    columns[i++].push_back(column.value(record));
  columns[i].push_back(true_um_[record.axis]);
  if (record.report.state == controller::AxisState::tracking && !tracks_since_s_[record.axis])
    tracks_since_s_[record.axis] = record.time_s;
}

void VirtualStage::run_until(double end_s, const std::function<void()>& go_on) {
  for (double left_s = end_s - time_s(); left_s > 0.0; left_s = end_s - time_s()) {
    go_on();
    loop_->run_for(std::min<can::Duration>(piece, duration_of(left_s)));
  }
}

bool VirtualStage::has_faulted() {
  for (std::size_t i = 0; i < axes().size(); ++i)
    if (loop_->controller().axis(i).state() == controller::AxisState::faulted) return true;
  return false;
}

bool VirtualStage::has_finished() {
  for (std::size_t i = 0; i < axes().size(); ++i)
    if (!tracks_since_s_[i] || time_s() < *tracks_since_s_[i] + lengths_s_[i]) return false;
  return true;
}

void VirtualStage::run_to_the_end(const std::function<void()>& go_on) {
  const double deadline_s = time_s() + start_up_limit_s + std::ranges::max(lengths_s_);
  while (!has_faulted() && !has_finished() && time_s() < deadline_s) run_until(time_s() + 0.01, go_on);
}

std::vector<std::pair<std::string, std::vector<double>>> VirtualStage::signals(
    const std::optional<std::string>& axis) const {
  if (!axis && axes().size() != 1)
    throw Error(fmt::format("there are {} axes, expected one of {}", axes().size(), fmt::join(axes(), ", ")));
  const std::size_t index = axis ? live_.axis_index(*axis) : 0;
  std::vector<std::pair<std::string, std::vector<double>>> signals;
  std::size_t i = 0;
  for (const controller::CycleColumn& column : controller::cycle_columns()) {
    if (column.kind != controller::CycleColumn::Kind::axis)
      signals.emplace_back(column.name, columns_[index][i]);
    ++i;
  }
  signals.emplace_back("true_position_um", columns_[index][i]);
  return signals;
}

std::map<std::string, std::string> VirtualStage::status() {
  std::map<std::string, std::string> states;
  for (std::size_t i = 0; i < axes().size(); ++i) {
    const controller::AxisReport& report = loop_->controller().axis(i).report();
    states[axes()[i]] = report.cause == controller::Cause::none
                            ? std::string(to_string(report.state))
                            : fmt::format("{}: {}", to_string(report.state), to_string(report.cause));
  }
  return states;
}

void VirtualStage::set(const std::string& axis, const std::string& key, const std::string& toml_value) {
  app::LiveConfig::Prepared prepared = live_.with(axis, key, toml_value);
  if (!prepared.after_restart.empty())
    throw Error(fmt::format("needs a restart: {}; give it in `settings` of a new Rehearsal",
                            describe(prepared.after_restart.front())));
  ask_all(std::move(prepared.requests));
  live_.accept(prepared);
}

void VirtualStage::ask(controller::Request::Kind kind, const std::optional<std::string>& axis,
                       double position_um) {
  std::vector<std::unique_ptr<controller::Request>> requests;
  for (std::size_t i = 0; i < axes().size(); ++i) {
    if (axis && live_.axis_index(*axis) != i) continue;
    requests.push_back(std::make_unique<controller::Request>());
    requests.back()->kind = kind;
    requests.back()->axis = i;
    requests.back()->position_um = position_um;
  }
  ask_all(std::move(requests));
}

void VirtualStage::ask_all(std::vector<std::unique_ptr<controller::Request>> requests) {
  std::size_t open = requests.size();
  for (auto& request : requests) requests_.ask(std::move(request));
  const double deadline_s = time_s() + 1.0;
  std::vector<std::string> refusals;
  while (open > 0 && time_s() < deadline_s) {
    loop_->run_for(duration_of(1.0 / config_.controller.rate_Hz));
    for (auto answer = requests_.take_answer(); answer; answer = requests_.take_answer(), --open)
      if (answer->refused_because)
        refusals.push_back(fmt::format("{}: {}", axes().at(answer->axis), *answer->refused_because));
  }
  if (open > 0) refusals.emplace_back("no answer: the controller is not running yet, or it has ended");
  if (!refusals.empty()) throw Error(fmt::format("{}", fmt::join(refusals, "; ")));
}

}  // namespace hystcan::python
