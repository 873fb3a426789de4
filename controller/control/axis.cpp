#include "controller/control/axis.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hystcan::controller {
namespace {

/// A reading of the output that is further from the drive than this share of the range has moved.
constexpr double output_moved = 0.01;

/// An amplifier that does not trip in this time without commands has no watchdog that would protect the
/// stage.
constexpr double watchdog_timeout_s = 1.0;

}  // namespace

AxisTuning::AxisTuning(const AxisConfig& next, bool new_reference) : config(next) {
  if (new_reference) reference = reference_of(next);
  if (next.learning) learning.emplace(*next.learning);
}

Axis::Axis(const AxisConfig& config)
    : config_(config),
      supervisor_(supervision_of(config)),
      output_check_(output_check_of(config)),
      course_(config.law.model, config.delays),
      ramp_check_(ramp_check_of(config)),
      oscillation_(oscillation_amplitude_um(config)),
      drive_(config.gate.safe_drive),
      reach_(reach_of(config)),
      memory_known_(config.start_up == StartUp::assume) {
  if (!config.excitation) {
    ramp_in_ = closed_loop_.emplace(config).ramp_in(config.gate);
    return;
  }
  excitation_.emplace(*config.excitation);
  refuse_beyond({config.gate.drive_min, config.gate.drive_max}, config.gate.slew_per_s, *excitation_);
  ramp_in_ = {excitation_->at(0.0)};
}

void Axis::start(bool clear_amplifier_fault) {
  state_ = AxisState::waiting;
  stopping_ = false;
  ramp_check_.restart();
  if (clear_amplifier_fault) clear_attempt_.begin();
}

bool Axis::clear() {
  if (state_ != AxisState::faulted || is_falling_) return false;
  state_ = AxisState::offline;
  fault_ = {};
  clear_attempt_.begin();
  return true;
}

void Axis::trip(Cause cause, double time_s) {
  const bool may_fall = state_ == AxisState::faulted ? is_falling_ : is_driving();
  if (!is_falling_) fall_per_s_ = config_.fault_ramp_per_s;
  is_falling_ = may_fall && fall_per_s_ > 0.0 && leaves_the_drive_in_hand(cause);
  if (state_ == AxisState::faulted) return;
  state_ = AxisState::faulted;
  fault_ = {cause, time_s};
  memory_known_ = false;  // the path on which the drive falls to its safe value is unknown
}

ClosedLoop* Axis::loop_for_live_setpoints() {
  return state_ == AxisState::tracking && !stopping_ ? closed_loop() : nullptr;
}

std::optional<Refusal> Axis::go_to(double position_um) {
  ClosedLoop* loop = loop_for_live_setpoints();
  if (loop == nullptr) return Refusal::not_tracking;
  // With NaN the comparison is false: the position is out of range.
  if (!(position_um >= reach_.lo && position_um <= reach_.hi)) return Refusal::position_out_of_range;
  loop->go_to(now_s_ - tracking_since_s_, position_um);
  return std::nullopt;
}

std::optional<Refusal> Axis::resume() {
  ClosedLoop* loop = loop_for_live_setpoints();
  if (loop == nullptr) return Refusal::not_tracking;
  loop->resume(now_s_ - tracking_since_s_);
  return std::nullopt;
}

std::optional<Refusal> Axis::retune(AxisTuning& tuning) {
  if (!closed_loop_) return Refusal::open_loop;
  const Gate::Config& gate = tuning.config.gate;
  if (is_driving() && (drive_ < gate.drive_min || drive_ > gate.drive_max))
    return Refusal::drive_out_of_range;
  std::swap(config_, tuning.config);
  reach_ = reach_of(config_);
  supervisor_.retune(supervision_of(config_));
  output_check_ = output_check_of(config_);
  output_check_.restart(drive_);
  ramp_check_ = RampCheck(ramp_check_of(config_));
  oscillation_ = Oscillation(oscillation_amplitude_um(config_));
  closed_loop_->retune(config_, tuning.reference, tuning.learning, now_s_ - tracking_since_s_);
  return std::nullopt;
}

const ControlLaw* Axis::law_to_save() const {
  return closed_loop_ && state_ == AxisState::offline && memory_known_ ? &closed_loop_->law() : nullptr;
}

void Axis::restore(const model::HysteresisState& memory) {
  if (!closed_loop_ || config_.start_up != StartUp::restore) return;
  closed_loop_->law().remember(memory);
  memory_known_ = true;
}

double Axis::expected_um(double time_s) const {
  if (!closed_loop_ || state_ != AxisState::tracking) return report_.position_um;
  return closed_loop_->reference_um(time_s - tracking_since_s_);
}

std::optional<Trajectory::Point> Axis::reference_at(double time_s) const {
  if (!closed_loop_ || state_ != AxisState::tracking || time_s < tracking_since_s_) return std::nullopt;
  return closed_loop_->reference_at(time_s - tracking_since_s_);
}

AxisCommand Axis::step(const AxisInput& input) {
  now_s_ = input.reference_time_s();
  if (input.position_um) report_.position_um = *input.position_um;
  report_.limits = limit::none;
  report_.arming_blocks = ArmingBlock::nothing;
  report_.watchdog_tripped_after_s.reset();
  report_.sample_missing = !input.position_um.has_value();
  report_.arrival = Arrival::not_judged;
  const AxisCommand command = is_driving() ? supervise(input) : decide(input);
  waited_s_ = input.waited_s;
  report_.state = state_;
  report_.cause = fault_.cause;
  report_.fault_time_s = fault_.time_s;
  report_.drive = command.drive;
  return command;
}

AxisCommand Axis::supervise(const AxisInput& input) {
  if (closed_loop_) closed_loop_->elapse(input.dt_s);  // the drive of the last cycle was held until now
  if (withheld_for_s_ && !stopping_) return withhold(input);
  const AxisInput judged = judge(input);
  report_.sample_missing = !judged.position_um.has_value();
  const AxisCommand command = decide(judged);
  if (state_ == AxisState::faulted) return command;
  const Cause cause = supervisor_.judge(command, report_.limits, input.dt_s);
  if (cause == Cause::none) return command;
  trip(cause, input.time_s);
  return fall(input);
}

/// Trips the axis, or takes a sample away that may not be used.
AxisInput Axis::judge(const AxisInput& input) {
  course_.step(drive_, input.dt_s, input.cycle_s);
  const Supervisor::Verdict verdict = supervisor_.judge(input, course_.moved_um(at_last_sample_));
  if (verdict.position_um) at_last_sample_ = course_.mark();
  AxisInput judged = input;
  judged.position_um = verdict.position_um;
  judged.dt_s -= input.waited_s - waited_s_;  // ramps, slew and law go on with the references
  output_check_.step(
      drive_, state_ == AxisState::initialising ? config_.wipe_slew_per_s : config_.gate.slew_per_s, input);
  // A position that stands still behind an output that does is not frozen.
  const bool is_still = verdict.cause == Cause::position_frozen && output_check_.differs_for_s() > 0.0;
  if (verdict.cause != Cause::none) trip(is_still ? Cause::output_differs : verdict.cause, input.time_s);
  if (output_differs_too_long()) trip(Cause::output_differs, input.time_s);
  if (state_ != AxisState::initialising) return judged;
  if (!connected_)
    ramp_check_.rest(course_, drive_, judged);
  else if (!ramp_check_.step(course_, drive_, judged))
    trip(Cause::position_contradicts, input.time_s);
  return judged;
}

/// While it ramps, the axis waits for an output that is behind.
bool Axis::output_differs_too_long() const {
  constexpr double ramping_s = 0.5, driving_s = 0.05;
  return output_check_.differs_for_s() > (state_ == AxisState::initialising ? ramping_s : driving_s);
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
    case AxisState::faulted:
      return fall(input);
    case AxisState::offline:
      break;
  }
  return safe();
}

AxisCommand Axis::wait(const AxisInput& input) {
  AxisCommand command = safe();
  command.clear_fault = clear_attempt_.step(input.health, input.dt_s);
  report_.arming_blocks = arming_blocks_of(input, config_.gate);
  if (report_.arming_blocks.first() == ArmingBlock::clear && !command.clear_fault)
    trip(Cause::amplifier_fault, input.time_s);
  if (report_.arming_blocks.empty()) arm(input.health);
  ramp_check_.rest(course_, drive_, input);
  return command;
}

void Axis::arm(const NodeHealth& health) {
  clear_attempt_ = {};  // what is left of it is not for a later start
  supervisor_.restart();
  drive_ = std::clamp(health.amplifier_output, config_.gate.drive_min, config_.gate.drive_max);
  follow(drive_);
  if (closed_loop_) closed_loop_->settle();
  output_check_.restart(drive_);
  course_.restart(drive_);
  connected_ = false;
  withheld_for_s_.reset();
  ramp_ = config_.start_up != StartUp::wipe && memory_known_ ? ramp_in_.size() : 0;
  dwelt_s_ = 0.0;
  state_ = AxisState::initialising;
}

AxisCommand Axis::initialise(const AxisInput& input) {
  if (!is_connected()) {
    report_.arming_blocks = ArmingBlock::enabled;
    follow_output(input.health.amplifier_output, input.dt_s);
    return {.drive = drive_, .enable = true};
  }
  if (output_check_.differs_for_s() > 0.0) {
    report_.arming_blocks = ArmingBlock::output;
    return {.drive = drive_, .enable = true};
  }
  if (config_.verify_watchdog && !watchdog_verified_) {
    report_.arming_blocks = ArmingBlock::watchdog;
    if (ramp_towards(config_.gate.safe_drive, input.dt_s)) withheld_for_s_ = 0.0;
    return {.drive = drive_, .enable = true};
  }
  if (ramp_ < ramp_in_.size() && ramp_towards(ramp_in_[ramp_], input.dt_s)) {
    dwelt_s_ += input.dt_s;
    if (dwelt_s_ >= config_.wipe_dwell_s) {
      dwelt_s_ = 0.0;
      ++ramp_;
    }
  }
  if (ramp_ == ramp_in_.size()) state_ = AxisState::ready;
  return {.drive = drive_, .enable = true};
}

// A relay or a soft start takes up to half a second from Enable to enabled. The output does not follow
// meanwhile, so a ramp on the wire would be a step at the stage.
bool Axis::is_connected() {
  connected_ |= supervisor_.enable_reported() &&
                supervisor_.enabled_for_s() >= std::chrono::duration<double>(config_.enable_delay).count();
  return connected_;
}

/// An output that falls while the relay is open would be lifted by a step when it closes.
void Axis::follow_output(double output, double dt_s) {
  const double range = config_.gate.drive_max - config_.gate.drive_min;
  if (!(std::abs(output - drive_) > output_moved * range)) output = drive_;
  drive_ = Gate::step(config_.gate, drive_, output, dt_s).drive;
  follow(drive_);
}

/// Everything but the amplifier's trip is judged as ever. After the trip the axis is armed again.
AxisCommand Axis::withhold(const AxisInput& input) {
  report_.arming_blocks = ArmingBlock::watchdog;
  if (input.health.amplifier_fault) {
    watchdog_verified_ = true;
    report_.watchdog_tripped_after_s = *withheld_for_s_;
    start(true);
    return safe();
  }
  AxisInput judged = input;
  judged.health.emergency = false;  // of the trip, before its status
  const Cause cause = supervisor_.judge(judged).cause;
  *withheld_for_s_ += input.dt_s;
  if (cause != Cause::none) trip(cause, input.time_s);
  if (*withheld_for_s_ > watchdog_timeout_s) trip(Cause::watchdog_failed, input.time_s);
  if (state_ == AxisState::faulted) return safe();
  return {.drive = drive_, .enable = true, .withheld = true};
}

AxisCommand Axis::hold_ready(const AxisInput& input) {
  if (!input.tracking_since_s || !input.position_um) {
    report_.arming_blocks = ArmingBlock::other_axes;
    return {.drive = drive_, .enable = true};
  }
  state_ = AxisState::tracking;
  const bool goes_on = tracking_since_s_ == *input.tracking_since_s;
  tracking_since_s_ = *input.tracking_since_s;
  memory_known_ = true;
  oscillation_.restart();
  if (closed_loop_)
    closed_loop_->begin(now_s_ - tracking_since_s_, *input.position_um, input.coupled_um, goes_on);
  return track(input);
}

AxisCommand Axis::track(const AxisInput& input) {
  const double t_s = now_s_ - tracking_since_s_;
  const std::optional<double> requested =
      closed_loop_ ? closed_loop_->propose(input, t_s, input.waited_s != waited_s_, report_) : excite(t_s);
  // An unstable loop loses its reference too: the oscillation explains more.
  if (input.position_um && oscillation_.step(report_.reference_um, *input.position_um))
    trip(Cause::loop_unstable, input.time_s);
  else if (!requested)
    trip(Cause::following_error, input.time_s);
  if (state_ == AxisState::faulted) return fall(input);
  const Gate::Passed passed = Gate::step(config_.gate, drive_, *requested, input.dt_s);
  report_.limits |= passed.limits;
  drive_ = passed.drive;
  if (closed_loop_) closed_loop_->commit(drive_, report_.limits);
  return {.drive = drive_, .enable = true};
}

/// In open loop the drive comes from the excitation.
double Axis::excite(double t_s) {
  report_.reference_um = report_.demand_um = std::numeric_limits<double>::quiet_NaN();
  report_.point = {.finished = t_s >= excitation_->length_s(), .shape_time_s = t_s};
  return excitation_->at(t_s);
}

AxisCommand Axis::park(const AxisInput& input) {
  if (state_ == AxisState::initialising && !connected_) {  // there is nothing to ramp behind an open relay
    state_ = AxisState::offline;
    return safe();
  }
  if (!is_driving() || ramp_towards(config_.gate.safe_drive, input.dt_s)) {
    state_ = AxisState::offline;
    clear_attempt_ = {};
    return safe();
  }
  state_ = AxisState::ready;
  return {.drive = drive_, .enable = true};
}

/// After a fault. It ends at once where bus or amplifier may not obey any more.
AxisCommand Axis::fall(const AxisInput& input) {
  const double safe_drive = config_.gate.safe_drive;
  output_check_.step(drive_, fall_per_s_, input);
  is_falling_ = is_falling_ && drive_ != safe_drive && obeys_commands(input.health) &&
                !is_status_too_old(input.health, config_.supervision.status_timeout) &&
                !output_differs_too_long();
  if (!is_falling_) return safe();
  drive_ = closer_to(safe_drive, fall_per_s_ * input.cycle_s, input.dt_s);
  return {.drive = drive_, .enable = true};
}

AxisCommand Axis::safe() const { return {.drive = config_.gate.safe_drive}; }

double Axis::closer_to(double target, double reach, double dt_s) const {
  const double next = std::clamp(target, drive_ - reach, drive_ + reach);
  return Gate::step(config_.gate, drive_, next, dt_s).drive;
}

bool Axis::ramp_towards(double target, double dt_s) {
  drive_ = closer_to(target, config_.wipe_slew_per_s * dt_s, dt_s);
  follow(drive_);
  return drive_ == std::clamp(target, config_.gate.drive_min, config_.gate.drive_max);
}

/// Keeps the model's memory equal to the actuator's.
void Axis::follow(double drive) {
  if (closed_loop_) closed_loop_->follow(drive);
}

bool Axis::is_driving() const {
  return state_ == AxisState::initialising || state_ == AxisState::ready || state_ == AxisState::tracking;
}

}  // namespace hystcan::controller
