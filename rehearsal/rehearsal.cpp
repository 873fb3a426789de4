#include "rehearsal/rehearsal.h"

#include <algorithm>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "controller/analysis/learning_design.h"
#include "rehearsal/true_error.h"

namespace hystcan::rehearsal {
namespace {

using controller::AxisState;

/// Longer than any start-up; a rehearsal that does not track by then never tracks.
constexpr double start_up_limit_s = 60.0;

double longest_reference_s(const controller::Config& config) {
  double longest = 0.0;
  for (const auto& axis : config.axes)
    longest = std::max(longest, controller::reference_of(axis.axis).length_s());
  return longest;
}

}  // namespace

Rehearsal::Rehearsal(const Setup& setup, controller::Controller::RecordHandler on_record)
    : bus_(clock_, setup.bitrate_bit_per_s),
      attach_([this](std::span<const can::Filter>) { return bus_.attach(); }),
      twin_(std::make_unique<twin::Twin>(
          setup.twin, setup.database, clock_,
          [this](std::span<const can::Filter>) { return bus_.attach(can::TransmitOrder::by_priority); })),
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
  while (!any_is(AxisState::faulted) && !all_finished() &&
         can::seconds(rehearsal.clock().now().time_since_epoch()) < deadline_s)
    rehearsal.run_for(std::chrono::milliseconds(10));

  Outcome outcome{.axes = {},
                  .true_errors = true_errors.statistics(),
                  .virtual_s = can::seconds(rehearsal.clock().now().time_since_epoch()),
                  .bus_load = rehearsal.bus().load(),
                  .counters = loop.counters()};
  for (std::size_t i = 0; i < loop.axis_count(); ++i)
    outcome.axes.push_back(controller::outcome_of(loop.axis_name(i), loop.axis(i), std::move(statistics[i])));
  return outcome;
}

namespace {

/// A structure for which no filter converges learns nothing.
void plan_learning_anew(controller::AxisConfig& axis, double rate_Hz) {
  try {
    controller::plan_learning(axis, rate_Hz);
  } catch (const std::invalid_argument&) {
    axis.learning.reset();
  }
}

}  // namespace

Setup with_structure(Setup setup, controller::Structure structure) {
  for (auto& axis : setup.controller.axes) {
    axis.axis.law.structure = structure;
    axis.axis.following_error.cycles =
        std::numeric_limits<unsigned>::max();  // an oscillation is judged as ever
    plan_learning_anew(axis.axis, setup.controller.rate_Hz);
  }
  return setup;
}

}  // namespace hystcan::rehearsal
