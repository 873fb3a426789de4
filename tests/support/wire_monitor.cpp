#include "tests/support/wire_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "controller/control/axis.h"

namespace hystcan::support {
namespace {

constexpr double lsb = 1e-6;  ///< drive units, config/hystcan.dbc
constexpr std::size_t kept = 12;
/// A SYNC counter repeats after 240 cycles. If the SYNC with this counter is older, it is a previous one, and
/// the named SYNC was lost.
constexpr auto sync_is_recent = std::chrono::milliseconds(100);

}  // namespace

std::string_view to_string(Violation violation) {
  static constexpr std::array<std::string_view, violation_count> names{
      "drive out of range",    "drive too fast",      "start not at the output", "unsafe when not enabled",
      "enabled while faulted", "output out of range", "output not safe",         "not switched off"};
  return names[static_cast<std::size_t>(violation)];
}

WireMonitor::WireMonitor(const Config& config, const can::Database& database)
    : config_(config),
      decode_command_(*can::find_layout<can::AmpCommand>(database, config.wire)),
      decode_status_(*can::find_layout<can::AmpStatus>(database, config.wire)),
      output_(config.gate.safe_drive) {
  if (const auto layout = can::find_layout<can::ControllerStatus>(database, config.wire))
    decode_report_.emplace(*layout);
  found_.reserve(kept);
}

void WireMonitor::receive(const can::Frame& frame, can::Time when) {
  if (frame.id == can::sync_id) {
    if (const auto counter = can::parse_sync(frame)) syncs_[*counter] = when;
  } else if (frame.id == decode_command_.id()) {
    if (const auto command = decode_command_(frame)) on_command(*command, when);
  } else if (frame.id == decode_status_.id()) {
    if (const auto status = decode_status_(frame)) on_status(*status, when);
  } else if (frame.id == can::heartbeat_base + config_.wire.amplifier_node) {
    if (can::parse_heartbeat(frame) == can::NmtState::boot_up)
      decode_status_.restart();  // the counter restarts at 0
  } else if (decode_report_ && frame.id == decode_report_->id()) {
    const auto report = (*decode_report_)(frame);
    if (report && report->state == static_cast<std::uint8_t>(controller::AxisState::faulted))
      report_fault(when);
  }
}

void WireMonitor::report_fault(can::Time when) {
  if (latched_) return;
  latched_ = true;
  latched_at_ = when;
}

void WireMonitor::report_clear() { latched_ = false; }

std::uint64_t WireMonitor::violations() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
}

void WireMonitor::on_command(const can::AmpCommand& command, can::Time when) {
  ++commands_;
  if (command.enable) return on_enabled(command, when);
  if (enabled_) safe_since_ = when;
  enabled_ = false;
  if (std::abs(command.setpoint - config_.gate.safe_drive) > lsb)
    note(Violation::unsafe_when_not_enabled, when, command.setpoint);
}

void WireMonitor::on_enabled(const can::AmpCommand& command, can::Time when) {
  if (latched_ && when > latched_at_ + config_.grace)
    note(Violation::enabled_while_faulted, when, command.setpoint);
  if (command.setpoint < config_.gate.drive_min - lsb || command.setpoint > config_.gate.drive_max + lsb)
    note(Violation::drive_out_of_range, when, command.setpoint);
  const can::Time taken = time_of_sync(command.sync_counter, when);
  judge_step(command.setpoint, taken, when);
  enabled_ = true;
  last_drive_ = command.setpoint;
  last_taken_ = taken;
  last_enabled_at_ = when;
}

void WireMonitor::judge_step(double setpoint, can::Time taken, can::Time when) {
  if (enabled_) {
    const double dt_s = can::seconds(std::max(taken - last_taken_, can::Duration::zero()) + config_.jitter);
    const double allowed = config_.gate.slew_per_s * dt_s + lsb;
    steepest_ = std::max(steepest_, std::abs(setpoint - last_drive_) / allowed);
    if (std::abs(setpoint - last_drive_) > allowed) note(Violation::drive_too_fast, when, setpoint);
    return;
  }
  const bool is_at_rest = !amplifier_enabled_ && when > switched_off_ + config_.settle;
  const double from = is_at_rest ? config_.gate.safe_drive : output_;
  const double allowed = config_.gate.slew_per_s * can::seconds(config_.grace + config_.jitter) + lsb;
  if (std::abs(setpoint - from) > allowed) note(Violation::start_not_at_output, when, setpoint);
}

can::Time WireMonitor::time_of_sync(std::uint8_t counter, can::Time when) const {
  const can::Time sync = syncs_[std::min(counter, can::sync_counter_max)];
  return when - sync < sync_is_recent ? sync : when;
}

void WireMonitor::on_status(const can::AmpStatus& status, can::Time when) {
  ++statuses_;
  const bool enabled = status.state == can::AmpState::enabled;
  if (amplifier_enabled_ && !enabled) switched_off_ = when;
  amplifier_enabled_ = enabled;
  output_ = status.output;
  if (output_ < config_.output_min - lsb || output_ > config_.output_max + lsb)
    note(Violation::output_out_of_range, when, output_);
  if (!enabled && when > switched_off_ + config_.settle &&
      std::abs(output_ - config_.gate.safe_drive) > config_.tolerance)
    note(Violation::output_not_safe, when, output_);
  if (enabled && !enabled_ && when > last_enabled_at_ + config_.off_within)
    note(Violation::not_switched_off, when, output_);
}

void WireMonitor::note(Violation violation, can::Time when, double value) {
  ++counts_[static_cast<std::size_t>(violation)];
  if (found_.size() < kept)
    found_.push_back(fmt::format("{} at {:.6f} s: {:g}", to_string(violation),
                                 can::seconds(when.time_since_epoch()), value));
}

}  // namespace hystcan::support
