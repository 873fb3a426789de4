#include "twin/fault_scheduler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::twin {
namespace {

/// Time between two changes of the stage's travel during a drift: the drift is a staircase.
constexpr can::Duration drift_step = std::chrono::milliseconds(1);

can::Duration duration_of(double s) { return can::Duration(std::llround(1e9 * s)); }

}  // namespace

FaultScheduler::FaultScheduler(can::Scheduler& scheduler, std::vector<FaultTarget> axes,
                               const std::vector<FaultSpec>& scheduled,
                               const std::optional<RandomFaults>& random)
    : scheduler_(scheduler),
      axes_(std::move(axes)),
      disturbances_(axes_.size()),
      scheduled_(scheduled),
      random_(random),
      random_source_(random ? random->seed : 0),
      timer_(scheduler.make_timer([this] { wake(); })) {
  for (const FaultSpec& spec : scheduled_) axis_of(spec);
  if (random_) list_random_faults();
}

void FaultScheduler::list_random_faults() {
  for (std::size_t i = 0; i < fault_count; ++i) {
    const auto kind = static_cast<Fault>(i);
    if (!random_->kinds.empty() && std::ranges::find(random_->kinds, kind) == random_->kinds.end()) continue;
    for (const FaultTarget& axis : axes_) {
      FaultSpec spec = fault_spec(kind, axis.wire.name);
      spec.lasts = random_->shortest;
      if (!reason_against(spec, axis.wire)) random_faults_.push_back(spec);
      if (traits(kind).site != FaultSite::either_node) continue;
      spec.node = Node::amplifier;
      if (!reason_against(spec, axis.wire)) random_faults_.push_back(spec);
    }
  }
  if (random_faults_.empty())
    throw std::invalid_argument(
        "random faults: none of the kinds is possible on this stage, expected another kind");
}

std::size_t FaultScheduler::axis_of(const FaultSpec& spec) const {
  const auto found =
      std::ranges::find(axes_, spec.axis, [](const FaultTarget& axis) { return axis.wire.name; });
  if (found == axes_.end())
    throw std::invalid_argument(
        fmt::format("there is no axis \"{}\", expected an axis of this twin", spec.axis));
  if (const auto reason = reason_against(spec, found->wire)) throw std::invalid_argument(*reason);
  return static_cast<std::size_t>(found - axes_.begin());
}

/// Returns true if both faults have the same kind and act at the same place. A fault that acts on a whole
/// node has one place for all axes of the node.
bool FaultScheduler::same_place(const FaultSpec& a, const FaultSpec& b) const {
  if (a.kind != b.kind) return false;
  if (traits(a.kind).site == FaultSite::plant) return a.axis == b.axis;
  if (a.node != b.node) return false;
  if (a.axis == b.axis || acts_on_one_axis(a.kind)) return a.axis == b.axis;
  const node::BusNode& node = axes_[axis_of(a)].node(a.node);
  return std::ranges::any_of(axes_, [&](const FaultTarget& axis) {
    return axis.wire.name == b.axis && &axis.node(b.node) == &node;
  });
}

void FaultScheduler::start(can::Time start) {
  planned_.clear();
  planned_.reserve(scheduled_.size());
  for (const FaultSpec& spec : scheduled_) planned_.push_back({spec, start + spec.begins});
  std::ranges::stable_sort(planned_, {}, &Planned::begins);
  if (random_) {
    next_random_ = start;
    plan_next_random();
  }
  wake();
}

void FaultScheduler::stop() {
  planned_.clear();
  next_random_ = can::Time::max();
  remove();
}

void FaultScheduler::inject(const FaultSpec& spec) {
  axis_of(spec);
  begin(spec);
  arm();
}

std::size_t FaultScheduler::remove(std::optional<Fault> kind, std::string_view axis) {
  const auto matches = [&](const FaultSpec& spec) {
    if (kind && spec.kind != *kind) return false;
    return axis.empty() ||
           same_place(spec, {.kind = spec.kind, .axis = std::string(axis), .node = spec.node});
  };
  const std::vector<Active> before = std::exchange(active_, {});
  std::ranges::copy_if(before, std::back_inserter(active_),
                       [&](const Active& one) { return !matches(one.spec); });
  for (const Active& one : before)
    if (matches(one.spec)) apply(one.spec, false);
  for (std::size_t i = 0; i < axes_.size(); ++i)
    if (disturbances_[i].gain != 1.0 && matches({.kind = Fault::parameter_drift, .axis = axes_[i].wire.name}))
      disturb(i, &Disturbance::gain, 1.0);
  arm();
  return before.size() - active_.size();
}

void FaultScheduler::wake() {
  const can::Time now = scheduler_.now();
  for (const Active& one : active_)
    if (one.spec.kind == Fault::parameter_drift) drift(one, now);
  end_what_is_due(now);
  begin_what_is_due(now);
  while (next_random_ <= now) begin_random_fault();
  arm();
}

void FaultScheduler::end_what_is_due(can::Time now) {
  const auto is_over = [now](const Active& one) { return one.ends <= now; };
  for (auto over = std::ranges::find_if(active_, is_over); over != active_.end();
       over = std::ranges::find_if(active_, is_over)) {
    const FaultSpec spec = over->spec;
    active_.erase(over);
    apply(spec, false);
  }
}

void FaultScheduler::begin_what_is_due(can::Time now) {
  for (Planned& next : planned_)
    while (next.begins <= now) {
      begin(next.spec);
      const bool repeats = next.spec.repeat_every > can::Duration::zero();
      next.begins = repeats ? next.begins + next.spec.repeat_every : can::Time::max();
    }
  std::erase_if(planned_, [](const Planned& one) { return one.begins == can::Time::max(); });
}

// Draws the time of the next random fault. The times between faults have an exponential distribution (Poisson
// process).
void FaultScheduler::plan_next_random() {
  const double mean_s = 3600.0 / random_->rate_per_hour;
  next_random_ += duration_of(-mean_s * std::log1p(-uniform())) + can::Duration{1};
}

void FaultScheduler::begin_random_fault() {
  const auto which = static_cast<std::size_t>(uniform() * static_cast<double>(random_faults_.size()));
  FaultSpec spec = random_faults_[which];
  const double range_s = can::seconds(random_->longest - random_->shortest);
  spec.lasts = random_->shortest + duration_of(uniform() * range_s);
  const bool either_sign = traits(spec.kind).site == FaultSite::plant;
  if (either_sign && uniform() < 0.5) spec.value = -spec.value;
  begin(spec);
  plan_next_random();
}

void FaultScheduler::arm() {
  can::Time next = next_random_;
  for (const Planned& one : planned_) next = std::min(next, one.begins);
  for (const Active& one : active_) {
    next = std::min(next, one.ends);
    if (one.spec.kind == Fault::parameter_drift) next = std::min(next, scheduler_.now() + drift_step);
  }
  if (next == can::Time::max()) return timer_->cancel();
  timer_->expire_at(next);
}

void FaultScheduler::begin(const FaultSpec& spec) {
  const can::Time now = scheduler_.now();
  const bool until_removed = spec.lasts == can::Duration::zero();
  std::erase_if(active_, [&](const Active& one) { return same_place(one.spec, spec); });
  active_.push_back({.spec = spec,
                     .began = now,
                     .ends = until_removed ? can::Time::max() : now + spec.lasts,
                     .gain_before = disturbances_[axis_of(spec)].gain});
  apply(spec, true);
}

/// Applies the begin (`begins` is true) or the end of a fault to the plant, the amplifier or the connection.
void FaultScheduler::apply(const FaultSpec& spec, bool begins) {
  const std::size_t index = axis_of(spec);
  const FaultTarget& axis = axes_[index];
  FaultyConnection& line = axis.line(spec.node);
  switch (spec.kind) {
    case Fault::parameter_drift:
      break;
    case Fault::resonance_shift:
      disturb(index, &Disturbance::resonance, begins ? 1.0 + spec.value : Disturbance{}.resonance);
      break;
    case Fault::load_step:
      disturb(index, &Disturbance::load_um, begins ? spec.value : Disturbance{}.load_um);
      break;
    case Fault::limited_output:
      disturb(index, &Disturbance::most_drive, begins ? spec.value : Disturbance{}.most_drive);
      break;
    case Fault::amplifier_trip:
      begins ? axis.amplifier.begin_internal_fault() : axis.amplifier.end_internal_fault();
      break;
    case Fault::relay_opens:
      begins ? axis.amplifier.open_relay() : axis.amplifier.release_relay();
      break;
    default:
      if (begins)
        line.begin(spec.kind, spec.value, axis.channel(spec.node));
      else
        line.end(spec.kind, axis.channel(spec.node));
      if (spec.kind == Fault::node_reboot && begins) axis.node(spec.node).lose_power();
      if ((spec.kind == Fault::node_reboot || spec.kind == Fault::bus_off) && !begins)
        axis.node(spec.node).restart();
  }
  if (on_event_) on_event_(spec, begins, scheduler_.now());
}

void FaultScheduler::drift(const Active& active, can::Time now) {
  const double share =
      std::clamp(can::seconds(now - active.began) / can::seconds(active.spec.lasts), 0.0, 1.0);
  const double target = 1.0 + active.spec.value;
  disturb(axis_of(active.spec), &Disturbance::gain,
          active.gain_before + share * (target - active.gain_before));
}

void FaultScheduler::disturb(std::size_t axis, double Disturbance::*what, double value) {
  disturbances_[axis].*what = value;
  axes_[axis].plant.advance_to(scheduler_.now());
  axes_[axis].plant.disturb(disturbances_[axis]);
}

}  // namespace hystcan::twin
