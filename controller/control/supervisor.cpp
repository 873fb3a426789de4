#include "controller/control/supervisor.h"

#include <algorithm>
#include <cmath>

#include "controller/control/gate.h"

namespace hystcan::controller {
namespace {

/// Maximum time between two SYNCs, in cycles. If it is longer, the controller has stalled: nothing has
/// supervised the stage for too long.
constexpr double stalled_cycles = 10.0;

/// Travel of the drive, as a share of its range. If the position does not change at all during this travel,
/// the sensor is frozen.
constexpr double frozen_travel = 0.02;

/// If the model cannot be inverted in this number of consecutive cycles, the axis trips. A corner of the
/// reference may cause one or two such cycles; an invalid model causes such cycles without end.
constexpr unsigned not_invertible_cycles = 3;

/// Returns the time between the last two SYNCs, as a rounded number of nominal cycles, at least 1. If SYNCs
/// were omitted, the time is longer, and the position may change more.
unsigned cycles_in(const AxisInput& input) {
  constexpr double most = 1e6;
  return static_cast<unsigned>(std::clamp(std::ceil(input.dt_s / input.cycle_s - 0.5), 1.0, most));
}

/// Returns the time for which `condition` has been true without interruption. `so_far_s`: this time in the
/// last cycle.
double time_held(bool condition, double so_far_s, double dt_s) { return condition ? so_far_s + dt_s : 0.0; }

}  // namespace

bool obeys_commands(const NodeHealth& health) {
  return health.interface_up && health.bus_on && !health.bus_passive && !health.commands_late &&
         !health.restarted && !health.emergency && health.amplifier_alive && health.amplifier_operational &&
         health.amplifier_enabled && !health.amplifier_fault;
}

bool is_status_too_old(const NodeHealth& health, std::chrono::nanoseconds timeout) {
  return timeout.count() > 0 && health.status_age_s > std::chrono::duration<double>(timeout).count();
}

void Supervisor::retune(const Config& config) {
  config_ = config;
  lost_tenths_ = 0;
}

void Supervisor::restart() { *this = Supervisor(config_); }

Supervisor::Verdict Supervisor::judge(const AxisInput& input, const model::Interval& course_um) {
  if (const Cause cause = judge_health(input); cause != Cause::none) return {cause, std::nullopt};
  return judge_sample(input, course_um);
}

Cause Supervisor::judge_health(const AxisInput& input) {
  const NodeHealth& health = input.health;
  if (!health.interface_up) return Cause::interface_down;
  if (!health.bus_on) return Cause::bus_off;
  passive_for_s_ = time_held(health.bus_passive, passive_for_s_, input.dt_s);
  if (config_.bus_passive_s > 0.0 && passive_for_s_ > config_.bus_passive_s) return Cause::bus_passive;
  if (input.dt_s > stalled_cycles * input.cycle_s) return Cause::cycle_overrun;
  if (health.commands_late) return Cause::commands_late;
  if (health.restarted) return Cause::node_restarted;
  if (health.amplifier_fault) return Cause::amplifier_fault;
  if (health.emergency) return Cause::node_emergency;
  if (!health.sensor_alive) return Cause::sensor_silent;
  if (!health.amplifier_alive) return Cause::amplifier_silent;
  if (!health.sensor_operational || !health.amplifier_operational) return Cause::node_not_operational;
  if (has_lost_enable(health)) return Cause::amplifier_not_enabled;
  return is_status_too_old(health, config_.status_timeout) ? Cause::status_missing : Cause::none;
}

/// True if the amplifier is not enabled any more, or if it was not enabled in time. A status that is older
/// than the first command with Enable is ignored.
bool Supervisor::has_lost_enable(const NodeHealth& health) {
  if (health.amplifier_enabled) {
    enable_reported_ |= health.status_age_s <= enabled_for_s_;
    return false;
  }
  return enable_reported_ || enabled_for_s_ > config_.enable_timeout_s;
}

Supervisor::Verdict Supervisor::judge_sample(const AxisInput& input, const model::Interval& course_um) {
  cycles_since_last_ += cycles_in(input);
  if (!input.position_um) return {count_missing_sample(input), std::nullopt};
  if (!input.sensor_status_good) return {Cause::sensor_status, std::nullopt};
  const double position_um = *input.position_um;
  // If the position is NaN, the comparison is false: the position is implausible.
  if (!(position_um >= config_.position_min_um && position_um <= config_.position_max_um))
    return {Cause::position_implausible, std::nullopt};
  if (has_jumped(position_um, course_um)) {
    ++lost_in_a_row_.jumped;
    return {count_lost_sample(Cause::position_jumped), std::nullopt};
  }
  if (is_frozen(position_um)) return {Cause::position_frozen, std::nullopt};
  if (lost_tenths_ > 0) --lost_tenths_;
  lost_in_a_row_ = {};
  last_um_ = position_um;
  cycles_since_last_ = 0;
  return {Cause::none, position_um};
}

/// Counts a missing sample. Returns the cause of the fault if too many samples are missing. If most of them
/// are missing in cycles that were too long, the cause is this computer and not the sensor node.
Cause Supervisor::count_missing_sample(const AxisInput& input) {
  if (input.late_sample) ++lost_in_a_row_.late;
  if (cycles_in(input) > 1) ++lost_in_a_row_.in_long_cycles;
  const Cause cause = count_lost_sample(Cause::sample_missing);
  const auto most = [&](unsigned part) { return 2 * part > lost_in_a_row_.all; };
  if (cause != Cause::sample_missing) return cause;
  if (most(lost_in_a_row_.in_long_cycles)) return Cause::cycle_overrun;
  return most(lost_in_a_row_.late) ? Cause::sample_late : cause;
}

Cause Supervisor::count_lost_sample(Cause cause) {
  lost_tenths_ += 10;
  ++lost_in_a_row_.all;
  return lost_tenths_ > 10 * config_.missing_samples ? cause : Cause::none;
}

bool Supervisor::has_jumped(double position_um, const model::Interval& course_um) const {
  if (config_.position_jump_um == 0.0 || !last_um_) return false;
  const double moved_um = position_um - *last_um_;
  const bool is_second = lost_in_a_row_.jumped > 0;
  const double beyond_um = is_second ? moved_um - std::clamp(moved_um, course_um.lo, course_um.hi) : moved_um;
  return std::abs(beyond_um) > config_.position_jump_um * (cycles_since_last_ - lost_in_a_row_.jumped);
}

bool Supervisor::is_frozen(double position_um) {
  if (config_.frozen_cycles == 0) return false;
  if (!last_um_ || position_um != *last_um_) {
    cycles_unchanged_ = 0;
    travel_ = 0.0;
    return false;
  }
  return ++cycles_unchanged_ >= config_.frozen_cycles && travel_ > frozen_travel * config_.drive_range;
}

Cause Supervisor::watch(const AxisCommand& command, std::uint8_t limits, double dt_s) {
  enabled_for_s_ = time_held(command.enable, enabled_for_s_, dt_s);
  travel_ += std::abs(command.drive - last_drive_);
  last_drive_ = command.drive;
  const bool is_limited = (limits & (limit::range | limit::slew | limit::model)) != 0;
  saturated_for_s_ = time_held(is_limited, saturated_for_s_, dt_s);
  if (config_.saturated_s > 0.0 && saturated_for_s_ > config_.saturated_s) return Cause::saturated;
  const bool left_range = (limits & (limit::not_invertible | limit::not_finite)) != 0;
  not_invertible_ = left_range ? not_invertible_ + 1 : 0;
  return not_invertible_ >= not_invertible_cycles ? Cause::model_left_range : Cause::none;
}

}  // namespace hystcan::controller
