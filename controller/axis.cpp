#include "controller/axis.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hystcan::controller {
namespace {

/// A SYNC so many cycles after the last one is a stall: the reference has run on, the ramps would jump.
constexpr double stalled_cycles = 10.0;

/// The amplifier reports its state at once; longer than this and it has not obeyed.
constexpr double enable_timeout_s = 0.5;

struct CauseText {
  std::string_view name;
  std::string_view remedy;
};

constexpr std::array<CauseText, cause_count> cause_texts{{
    {"none", ""},
    {"interface down", "bring the CAN interface up and start the controller again"},
    {"bus-off", "check wiring, termination and bit rate, then start the controller again"},
    {"cycle overrun",
     "the computer was kept from its work: give the controller a real-time class, chrt --fifo 50"},
    {"sample missing", "check the sensor node and the bus load"},
    {"sensor status", "the sensor reports a bad sample: check the sensor"},
    {"position implausible",
     "the position is outside position_min_um..position_max_um: check sensor and stage"},
    {"sensor silent", "no heartbeat from the sensor node: check its supply and cable"},
    {"amplifier silent", "no heartbeat from the amplifier node: check its supply and cable"},
    {"node restarted", "a node booted up while in use: check its supply"},
    {"node not set up",
     "a node refused or did not keep an object of its setup: see the log, check index and value"},
    {"amplifier fault",
     "the amplifier has tripped: find out why, then start the controller with --clear-faults"},
    {"amplifier not enabled", "the amplifier does not obey Enable: check its interlocks"},
    {"following error", "the stage does not follow: check load and model, or raise following_error_um"},
    {"command not sendable",
     "the drive does not fit the Setpoint signal: check the DBC against drive_min and drive_max"},
    {"another controller is on this bus",
     "somebody else sends SYNC, this controller's heartbeat or its commands: end one of the two"},
}};

Loop make_loop(const AxisConfig& config) {
  if (config.excitation) return OpenLoop(*config.excitation, config.gate);
  return ClosedLoop({.law = config.law,
                     .delays = config.delays,
                     .setpoint = config.setpoint,
                     .repeat = config.repeat,
                     .following_error_um = config.following_error_um,
                     .following_error_cycles = config.following_error_cycles});
}

/// From the lower threshold, coming down, to the upper one; within what is plausible.
model::Interval reach_of(const AxisConfig& config) {
  model::Interval reach{config.position_min_um, config.position_max_um};
  if (config.excitation) return reach;
  const model::HysteresisParameters& model = config.law.model;
  const model::Interval& thresholds = model.ascending.domain();
  return {std::max(reach.lo, model.descending.value(thresholds.lo)),
          std::min(reach.hi, model.ascending.value(thresholds.hi))};
}

}  // namespace

std::string_view to_string(AxisState state) {
  static constexpr std::array<std::string_view, axis_state_count> names{"offline", "waiting",  "initialising",
                                                                        "ready",   "tracking", "faulted"};
  return names[static_cast<std::size_t>(state)];
}

std::string_view to_string(Cause cause) { return cause_texts[static_cast<std::size_t>(cause)].name; }
std::string_view remedy(Cause cause) { return cause_texts[static_cast<std::size_t>(cause)].remedy; }

Axis::Axis(const AxisConfig& config)
    : config_(config),
      loop_(make_loop(config)),
      ramp_in_(std::visit([](const auto& loop) { return loop.ramp_in(); }, loop_)),
      lost_samples_(config.missing_samples),
      drive_(config.gate.safe_drive),
      reach_(reach_of(config)) {}

void Axis::start(bool clear_amplifier_fault) {
  state_ = AxisState::waiting;
  clear_amplifier_fault_ = clear_amplifier_fault;
}

void Axis::trip(Cause cause, double time_s) {
  if (state_ == AxisState::faulted) return;
  state_ = AxisState::faulted;
  fault_ = {cause, time_s};
}

bool Axis::takes_live_setpoints() const {
  return state_ == AxisState::tracking && !stopping_ && std::holds_alternative<ClosedLoop>(loop_);
}

LiveSetpoint Axis::go_to(double position_um) {
  if (!takes_live_setpoints()) return LiveSetpoint::not_tracking;
  // Written so that NaN is out of range too.
  if (!(position_um >= reach_.lo && position_um <= reach_.hi)) return LiveSetpoint::out_of_range;
  live_goal_um_ = position_um;
  return LiveSetpoint::taken;
}

LiveSetpoint Axis::resume() {
  if (!takes_live_setpoints()) return LiveSetpoint::not_tracking;
  live_goal_um_.reset();
  return LiveSetpoint::taken;
}

AxisCommand Axis::step(const AxisInput& input) {
  report_.sample_missing = !input.position_um.has_value();
  if (input.position_um) report_.position_um = *input.position_um;
  report_.limits = limit::none;

  if (const Cause cause = find_cause(input); cause != Cause::none) trip(cause, input.time_s);
  const AxisCommand command = decide(input);
  enabled_for_s_ = command.enable ? enabled_for_s_ + input.dt_s : 0.0;

  report_.state = state_;
  report_.cause = fault_.cause;
  report_.drive = command.drive;
  return command;
}

/// Everything that must not be while the axis is driven, the most telling cause first.
Cause Axis::find_cause(const AxisInput& input) {
  if (!is_driving()) return Cause::none;
  const NodeHealth& health = input.health;
  if (!health.interface_up) return Cause::interface_down;
  if (!health.bus_on) return Cause::bus_off;
  if (input.dt_s > stalled_cycles * input.cycle_s) return Cause::cycle_overrun;
  if (health.restarted) return Cause::node_restarted;
  if (health.amplifier_fault) return Cause::amplifier_fault;
  if (!health.sensor_alive || !health.sensor_operational) return Cause::sensor_silent;
  if (!health.amplifier_alive || !health.amplifier_operational) return Cause::amplifier_silent;
  if (enabled_for_s_ > enable_timeout_s && !health.amplifier_enabled) return Cause::amplifier_not_enabled;
  if (!input.position_um) {
    lost_samples_.lose();
    return lost_samples_.overflows() ? Cause::sample_missing : Cause::none;
  }
  lost_samples_.leak();
  if (!input.sensor_status_good) return Cause::sensor_status;
  // Written so that NaN is implausible too.
  if (!(*input.position_um >= config_.position_min_um && *input.position_um <= config_.position_max_um))
    return Cause::position_implausible;
  return Cause::none;
}

AxisCommand Axis::decide(const AxisInput& input) {
  if (stopping_ && state_ != AxisState::faulted) return park(input);
  switch (state_) {
    case AxisState::waiting:
      return wait(input);
    case AxisState::initialising:
      return initialise(input);
    case AxisState::ready:
      return hold_ready(input);
    case AxisState::tracking:
      return track(input);
    case AxisState::offline:
    case AxisState::faulted:
      break;
  }
  return safe();
}

AxisCommand Axis::wait(const AxisInput& input) {
  const NodeHealth& health = input.health;
  AxisCommand command = safe();
  if (health.amplifier_fault) {
    if (!clear_amplifier_fault_) trip(Cause::amplifier_fault, input.time_s);
    command.clear_fault = clear_amplifier_fault_;
  } else if (health.sensor_operational && health.amplifier_operational && health.amplifier_ready &&
             input.position_um) {
    clear_amplifier_fault_ = false;
    lost_samples_.empty();
    drive_ = health.amplifier_output;
    ramp_ = 0;
    dwelt_s_ = 0.0;
    state_ = AxisState::initialising;
  }
  return command;
}

AxisCommand Axis::initialise(const AxisInput& input) {
  if (ramp_towards(ramp_in_[ramp_], input.dt_s)) {
    dwelt_s_ += input.dt_s;
    if (dwelt_s_ >= config_.wipe_dwell_s) {
      dwelt_s_ = 0.0;
      if (++ramp_ == ramp_in_.size()) state_ = AxisState::ready;
    }
  }
  return {.drive = drive_, .enable = true};
}

AxisCommand Axis::hold_ready(const AxisInput& input) {
  if (!input.begin_tracking || !input.position_um) return {.drive = drive_, .enable = true};
  state_ = AxisState::tracking;
  tracking_since_s_ = input.time_s;
  live_goal_um_.reset();
  std::visit([&](auto& loop) { loop.begin(*input.position_um); }, loop_);
  return track(input);
}

AxisCommand Axis::track(const AxisInput& input) {
  const LoopInput now{.t_s = input.time_s - tracking_since_s_,
                      .dt_s = input.dt_s,
                      .cycle_s = input.cycle_s,
                      .position_um = input.position_um};
  const Proposal proposal = std::visit([&](auto& loop) { return loop.propose(now); }, loop_);
  report_.point = proposal.point;
  report_.reference_um = proposal.reference_um;
  if (!proposal.follows) {
    trip(Cause::following_error, input.time_s);
    return safe();
  }
  const Gate::Passed passed = Gate::step(config_.gate, drive_, proposal.drive, input.dt_s);
  std::visit([&](auto& loop) { loop.commit(passed.drive); }, loop_);
  drive_ = passed.drive;
  report_.demand_um = proposal.demand_um;
  report_.limits = proposal.limits | passed.limits;
  return {.drive = drive_, .enable = true};
}

AxisCommand Axis::park(const AxisInput& input) {
  if (!is_driving() || ramp_towards(config_.gate.safe_drive, input.dt_s)) {
    state_ = AxisState::offline;
    return safe();
  }
  state_ = AxisState::ready;
  return {.drive = drive_, .enable = true};
}

AxisCommand Axis::safe() const { return {.drive = config_.gate.safe_drive}; }

bool Axis::ramp_towards(double target, double dt_s) {
  const double reach = config_.wipe_slew_per_s * dt_s;
  const double wanted = std::clamp(target, drive_ - reach, drive_ + reach);
  drive_ = Gate::step(config_.gate, drive_, wanted, dt_s).drive;
  return drive_ == std::clamp(target, config_.gate.drive_min, config_.gate.drive_max);
}

bool Axis::is_driving() const {
  return state_ == AxisState::initialising || state_ == AxisState::ready || state_ == AxisState::tracking;
}

}  // namespace hystcan::controller
