#include "rehearsal/rehearsal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "can/protocol/protocol.h"
#include "controller/analysis/learning_design.h"

namespace hystcan::rehearsal {

TrueErrors::TrueErrors(const twin::Config& config, twin::Twin& twin, const controller::Controller& controller,
                       const can::Attach& attach, double settle_s)
    : controller_(controller), bus_(attach(std::array{can::Filter{can::sync_id}})) {
  bus_->on_frame([this](const can::Frame& frame, can::Time received) {
    if (can::parse_sync(frame)) last_sync_ = received;
  });
  for (std::size_t i = 0; i < controller.axis_count(); ++i) {
    const auto same = [&](const auto& axis) { return axis->name == controller.wired_axis(i).wire.name; };
    stages_.push_back(
        static_cast<std::size_t>(std::ranges::find_if(twin.axes(), same) - twin.axes().begin()));
  }
  for (std::size_t i = 0; i < twin.axes().size(); ++i) {
    const auto controlled = std::ranges::find(stages_, i);
    twin::Plant& plant = twin.axes()[i]->plant;
    const twin::AxisConfig& stage = config.axes[i].axis;
    axes_.push_back(std::make_unique<Axis>(
        Axis{.substep = stage.plant.substep,
             .couplings = stage.couplings,
             .start_um = plant.position_um(),
             .points = {},
             .statistics = controller::TrackingStatistics(
                 controlled == stages_.end()
                     ? 0
                     : controller.axis(static_cast<std::size_t>(controlled - stages_.begin()))
                           .config()
                           .setpoint.size(),
                 settle_s)}));
    plant.on_grid([this, &axis = *axes_.back()](can::Time time, double own_um) { take(axis, time, own_um); });
  }
}

/// Stores the position of a plant (`own_um`) at the end of a sub-step. The plant may combine several
/// sub-steps into one long step. For each sub-step in it, a position is then stored by linear interpolation,
/// so that the statistics weight all times equally.
void TrueErrors::take(Axis& axis, can::Time time, double own_um) {
  if (!axis.points.empty()) {
    const Point last = axis.points.back();
    const double steps = can::seconds(time - last.time) / can::seconds(axis.substep);
    for (int step = 1; last.time + step * axis.substep < time; ++step)
      axis.points.push_back({last.time + step * axis.substep, std::lerp(last.own_um, own_um, step / steps)});
  }
  axis.points.push_back({time, own_um});
}

void TrueErrors::add(const controller::CycleRecord& record) {
  if (!last_sync_ || (!cycles_.empty() && cycles_.back().begins == *last_sync_)) return;
  cycles_.push_back({*last_sync_, record.time_s});
  while (cycles_.size() > 1 && is_known_until(cycles_[1].begins)) {
    for (std::size_t i = 0; i < stages_.size(); ++i)
      if (stages_[i] < axes_.size()) judge(i, cycles_[0], cycles_[1].begins);
    for (const auto& axis : axes_)
      while (axis->points.size() > 1 && axis->points[1].time < cycles_[1].begins) axis->points.pop_front();
    cycles_.pop_front();
  }
}

/// Returns true if every controlled plant has computed its sub-steps until `time`. Plants without a
/// controller are ignored: they rest and may never step.
bool TrueErrors::is_known_until(can::Time time) const {
  return std::ranges::all_of(stages_, [&](std::size_t stage) {
    if (stage >= axes_.size()) return true;
    const Axis& axis = *axes_[stage];
    return !axis.points.empty() && axis.points.back().time + axis.substep >= time;
  });
}

void TrueErrors::judge(std::size_t index, const Cycle& cycle, can::Time end) {
  Axis& axis = *axes_[stages_[index]];
  for (const Point& point : axis.points) {
    if (point.time < cycle.begins || point.time >= end) continue;
    const auto reference =
        controller_.axis(index).reference_at(cycle.time_s + can::seconds(point.time - cycle.begins));
    if (!reference) continue;
    controller::AxisReport report;
    report.state = controller::AxisState::tracking;
    report.point = *reference;
    report.reference_um = reference->value_um;
    report.position_um = point.own_um + coupled_um(axis, point.time);
    axis.statistics.add(report);
  }
}

double TrueErrors::coupled_um(const Axis& axis, can::Time time) const {
  double sum_um = 0.0;
  for (const model::Coupling& coupling : axis.couplings) {
    const Axis& from = *axes_[coupling.index];
    const auto after = std::ranges::lower_bound(from.points, time, {}, &Point::time);
    if (after == from.points.end() || (after->time != time && after == from.points.begin())) continue;
    double own_um = after->own_um;
    if (after->time != time) {
      const auto before = std::prev(after);
      const double share = can::seconds(time - before->time) / can::seconds(after->time - before->time);
      own_um = std::lerp(before->own_um, after->own_um, share);
    }
    sum_um += coupling.um_per_um * (own_um - from.start_um);
  }
  return sum_um;
}

std::vector<controller::TrackingStatistics> TrueErrors::statistics() const {
  std::vector<controller::TrackingStatistics> all;
  for (const std::size_t stage : stages_)
    all.push_back(stage < axes_.size() ? axes_[stage]->statistics : controller::TrackingStatistics(0, 0.0));
  return all;
}

namespace {

using controller::AxisState;

/// Maximum time from power-on to the start of the reference. It is longer than any start-up, so a rehearsal
/// that takes longer would never track.
constexpr double start_up_limit_s = 60.0;

double longest_reference_s(const controller::Config& config) {
  double longest = 0.0;
  for (const auto& axis : config.axes)
    longest = std::max(longest, controller::reference_of(axis.axis).length_s());
  return longest;
}

/// Designs the learning filter for the axis's new control structure. If no filter lets the learning converge,
/// switches learning off for the axis.
void plan_learning_anew(controller::AxisConfig& axis, double rate_Hz) {
  try {
    controller::plan_learning(axis, rate_Hz);
  } catch (const std::invalid_argument&) {
    axis.learning.reset();
  }
}

}  // namespace

Rehearsal::Rehearsal(const Setup& setup, controller::Controller::RecordHandler on_record)
    : bus_(clock_, setup.rates),
      attach_([this](std::span<const can::Filter> filters) {
        return bus_.attach(can::TransmitOrder::as_sent, filters);
      }),
      twin_(std::make_unique<twin::Twin>(setup.twin, setup.database, clock_,
                                         [this](std::span<const can::Filter> filters) {
                                           return bus_.attach(can::TransmitOrder::by_priority, filters);
                                         })),
      controller_(setup.controller, setup.database, clock_, attach_, std::move(on_record)) {}

void Rehearsal::start() {
  twin_->start();
  controller_.start();
}

void Rehearsal::run_for(can::Duration duration) { clock_.run_until(clock_.now() + duration); }

Outcome run_once(const Setup& setup, double settle_s, const controller::Controller::RecordHandler& on_record,
                 const twin::TruthHandler& on_truth) {
  Setup once = setup;
  std::vector<controller::TrackingStatistics> statistics;
  for (auto& axis : once.controller.axes) {
    axis.axis.repeat = false;
    statistics.emplace_back(axis.axis, settle_s);
  }
  TrueErrors* truth = nullptr;
  Rehearsal rehearsal(once, [&](const controller::CycleRecord& record) {
    statistics[record.axis].add(record.report);
    truth->add(record);
    on_record(record);
  });
  TrueErrors true_errors(once.twin, rehearsal.twin(), rehearsal.controller(), rehearsal.attach(), settle_s);
  truth = &true_errors;
  if (on_truth) rehearsal.twin().on_truth(on_truth);
  rehearsal.start();

  const controller::Controller& loop = rehearsal.controller();
  const auto any_is = [&](AxisState state) {
    for (std::size_t i = 0; i < loop.axis_count(); ++i)
      if (loop.axis(i).state() == state) return true;
    return false;
  };
  const double deadline_s = start_up_limit_s + longest_reference_s(once.controller);
  const auto all_finished = [&] {
    for (std::size_t i = 0; i < loop.axis_count(); ++i)
      if (!loop.axis(i).report().point.finished) return false;
    return true;
  };
  while (!any_is(AxisState::faulted) && !all_finished() && rehearsal.time_s() < deadline_s)
    rehearsal.run_for(std::chrono::milliseconds(10));

  Outcome outcome{.axes = {},
                  .true_errors = true_errors.statistics(),
                  .virtual_s = rehearsal.time_s(),
                  .bus_load = rehearsal.bus().load(),
                  .counters = loop.counters()};
  for (std::size_t i = 0; i < loop.axis_count(); ++i)
    outcome.axes.push_back(
        controller::outcome_of(loop.wired_axis(i).wire.name, loop.axis(i), std::move(statistics[i])));
  return outcome;
}

Setup with_structure(Setup setup, controller::Structure structure) {
  for (auto& axis : setup.controller.axes) {
    axis.axis.law.structure = structure;
    axis.axis.following_error.cycles =
        std::numeric_limits<unsigned>::max();  // no following-error trip; the oscillation trip remains
    plan_learning_anew(axis.axis, setup.controller.rate_Hz);
  }
  return setup;
}

}  // namespace hystcan::rehearsal
