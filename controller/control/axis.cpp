#include "controller/control/axis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hystcan::controller {
namespace {

/// Returns the drive of the excitation in open loop, and fills the values of the reference into `report`.
double excite(const Excitation& excitation, double t_s, AxisReport& report) {
  report.reference_um = report.demand_um = std::numeric_limits<double>::quiet_NaN();
  report.point = {.finished = t_s >= excitation.length_s(), .shape_time_s = t_s};
  return excitation.at(t_s);
}

}  // namespace

AxisTuning::AxisTuning(const AxisConfig& next, bool new_reference) : config(next) {
  if (new_reference) reference = reference_of(next);
  if (next.learning) learning.emplace(*next.learning);
}

Axis::Axis(const AxisConfig& config)
    : config_(config),
      start_up_(config),
      supervisor_(supervision_of(config)),
      output_check_(output_check_of(config)),
      course_(config.law.model, config.delays),
      oscillation_(oscillation_amplitude_um(config)),
      drive_(config.gate.safe_drive),
      reach_(reach_of(config)),
      memory_known_(config.start_up == MemorySource::assume) {
  if (!config.excitation) {
    start_up_.visit(closed_loop_.emplace(config).ramp_in(config.gate));
    return;
  }
  excitation_.emplace(*config.excitation);
  refuse_beyond({config.gate.drive_min, config.gate.drive_max}, config.gate.slew_per_s, *excitation_);
  start_up_.visit({excitation_->at(0.0)});
}

void Axis::start(bool clear_amplifier_fault) {
  state_ = AxisState::waiting;
  stopping_ = false;
  start_up_.begin(clear_amplifier_fault);
}

std::optional<Refusal> Axis::clear() {
  if (fall_.state() == Fall::State::ramping) return Refusal::still_ramping;
  if (state_ != AxisState::faulted) return Refusal::no_fault_to_clear;
  state_ = AxisState::offline;
  fall_ = {};
  start_up_.attempt_clear(true);
  return std::nullopt;
}

void Axis::trip(Cause cause, double time_s) {
  fall_.trip({cause, time_s}, controller::is_in_use(state_), config_.fault_ramp_per_s);
  state_ = AxisState::faulted;
  memory_known_ = false;  // the actuator now moves on a path that is not known
}

ClosedLoop* Axis::loop_for_live_setpoints() {
  return state_ == AxisState::tracking && !stopping_ ? closed_loop() : nullptr;
}

std::optional<Refusal> Axis::go_to(double position_um) {
  ClosedLoop* loop = loop_for_live_setpoints();
  if (loop == nullptr) return Refusal::not_tracking;
  // If the position is NaN, the comparison is false: the position is out of range.
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
  finish();
  const Gate::Config& gate = tuning.config.gate;
  if (controller::is_in_use(state_) && (drive_ < gate.drive_min || drive_ > gate.drive_max))
    return Refusal::drive_out_of_range;
  std::swap(config_, tuning.config);
  reach_ = reach_of(config_);
  supervisor_.retune(supervision_of(config_));
  output_check_ = output_check_of(config_);
  output_check_.restart(drive_);
  start_up_.retune(config_);
  oscillation_ = Oscillation(oscillation_amplitude_um(config_));
  closed_loop_->retune(config_, tuning.reference, tuning.learning, now_s_ - tracking_since_s_);
  return std::nullopt;
}

const ControlLaw* Axis::law_to_save() const {
  return closed_loop_ && state_ == AxisState::offline && memory_known_ ? &closed_loop_->law() : nullptr;
}

void Axis::restore(const model::HysteresisState& memory) {
  if (!closed_loop_ || config_.start_up != MemorySource::restore) return;
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
  const AxisCommand command = decide(input);
  finish();
  return command;
}

void Axis::prepare(double reference_time_s, double cycle_s) {
  if (closed_loop_ && state_ == AxisState::tracking)
    closed_loop_->prepare(reference_time_s - tracking_since_s_, cycle_s);
}

void Axis::finish() {
  if (std::exchange(finished_, true)) return;
  if (const auto drive = std::exchange(uncommitted_drive_, std::nullopt))
    closed_loop_->commit(*drive, report_.limits);
  if (controller::is_in_use(state_)) course_.follow(drive_);
}

AxisCommand Axis::decide(const AxisInput& input) {
  finish();
  finished_ = false;
  now_s_ = input.reference_time_s();
  if (input.position_um) report_.position_um = *input.position_um;
  report_.limits = limit::none;
  report_.arming_blocks = ArmingBlock::nothing;
  report_.watchdog_tripped_after_s.reset();
  report_.sample_missing = !input.position_um.has_value();
  report_.arrival = Arrival::not_judged;
  const AxisCommand command = controller::is_in_use(state_) ? supervise(input) : act(input);
  waited_s_ = input.waited_s;
  report_.state = state_;
  report_.cause = fault().cause;
  report_.fault_time_s = fault().time_s;
  report_.drive = command.drive;
  return command;
}

AxisCommand Axis::supervise(const AxisInput& input) {
  if (closed_loop_) closed_loop_->elapse(input.dt_s);  // the drive of the last cycle was held until now
  if (start_up_.state() == StartUp::State::withholding && !stopping_) {
    // During the trial of the watchdog, a trip of the amplifier is no fault. The emergency that may arrive
    // before the status with the trip is ignored. All other causes are judged as usual.
    AxisInput judged = input;
    judged.health.emergency = false;
    const Cause cause = input.health.amplifier_fault ? Cause::none : supervisor_.judge(judged).cause;
    if (cause != Cause::none) trip(cause, input.time_s);
    const AxisCommand command = start_up(input);
    return state_ == AxisState::faulted ? config_.safe_command() : command;
  }
  const AxisInput examined = examine(input);
  report_.sample_missing = !examined.position_um.has_value();
  const AxisCommand command = act(examined);
  if (state_ == AxisState::faulted) return command;
  const Cause cause = supervisor_.watch(command, report_.limits, input.dt_s);
  if (cause == Cause::none) return command;
  trip(cause, input.time_s);
  return fall_.step(config_, input, output_check_, drive_);
}

/// Returns the input, without its sample if the sample may not be used. Trips the axis if a check finds the
/// cause of a fault.
AxisInput Axis::examine(const AxisInput& input) {
  course_.elapse(input.dt_s, input.cycle_s);
  const Supervisor::Verdict verdict = supervisor_.judge(input, course_.moved_um(at_last_sample_));
  if (verdict.position_um) at_last_sample_ = course_.mark();
  AxisInput examined = input;
  examined.position_um = verdict.position_um;
  // A late SYNC makes the references wait. This time is subtracted, so that ramps, slew and law wait too.
  examined.dt_s -= input.waited_s - waited_s_;
  const bool ramps = state_ == AxisState::initialising;
  output_check_.step(drive_, ramps ? config_.wipe_slew_per_s : config_.gate.slew_per_s, input);
  // If the amplifier's output does not follow the drive, this explains why the position does not change.
  const bool is_still = verdict.cause == Cause::position_frozen && output_check_.differs_for_s() > 0.0;
  if (verdict.cause != Cause::none) trip(is_still ? Cause::output_differs : verdict.cause, input.time_s);
  if (output_check_.differs_too_long(state_ == AxisState::initialising))
    trip(Cause::output_differs, input.time_s);
  if (state_ == AxisState::initialising && !start_up_.agrees(course_, drive_, examined))
    trip(Cause::position_contradicts, input.time_s);
  return examined;
}

AxisCommand Axis::act(const AxisInput& input) {
  if (stopping_ && state_ != AxisState::faulted) return park(input);
  switch (state_) {
    case AxisState::waiting:
    case AxisState::initialising:
      return start_up(input);
    case AxisState::ready:
      return hold_ready(input);
    case AxisState::tracking:
      return track(input);
    case AxisState::faulted:
      return fall_.step(config_, input, output_check_, drive_);
    case AxisState::offline:
      break;
  }
  return config_.safe_command();
}

AxisCommand Axis::start_up(const AxisInput& input) {
  const StartUp::State before = start_up_.state();
  const bool is_enabled =
      supervisor_.enable_reported() &&
      supervisor_.enabled_for_s() >= std::chrono::duration<double>(config_.enable_delay).count();
  const StartUp::Step taken = start_up_.step(
      config_, input,
      {.enabled = is_enabled, .output_differs = output_check_.differs_for_s() > 0.0, .memory = memory_known_},
      drive_, report_);
  if (taken.moves && closed_loop_) closed_loop_->follow(drive_);
  if (before == StartUp::State::arming && start_up_.state() == StartUp::State::following) {
    supervisor_.restart();
    if (closed_loop_) closed_loop_->settle();
    output_check_.restart(drive_);
    course_.restart(drive_);
    state_ = AxisState::initialising;
  }
  if (before == StartUp::State::arming) start_up_.agrees(course_, drive_, input);
  if (before == StartUp::State::withholding && start_up_.state() == StartUp::State::arming)
    state_ = AxisState::waiting;
  if (start_up_.state() == StartUp::State::ended) state_ = AxisState::ready;
  if (taken.cause != Cause::none) trip(taken.cause, input.time_s);
  return taken.command;
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
      closed_loop_ ? closed_loop_->propose(input, t_s, input.waited_s != waited_s_, report_)
                   : excite(*excitation_, t_s, report_);
  // An unstable loop also causes a following error. Its oscillation is the better explanation, so it is
  // tested first.
  if (input.position_um && oscillation_.step(report_.reference_um, *input.position_um))
    trip(Cause::loop_unstable, input.time_s);
  else if (!requested)
    trip(Cause::following_error, input.time_s);
  if (state_ == AxisState::faulted) return fall_.step(config_, input, output_check_, drive_);
  const Gate::Passed passed = Gate::step(config_.gate, drive_, *requested, input.dt_s);
  report_.limits |= passed.limits;
  drive_ = passed.drive;
  if (closed_loop_) uncommitted_drive_ = drive_;
  return {.drive = drive_, .enable = true};
}

AxisCommand Axis::park(const AxisInput& input) {
  // In StartUp::State::following, the amplifier is not enabled yet: its relay is open, and the stage is not
  // driven. The drive may therefore become the safe drive at once, without a ramp.
  const bool is_open = state_ == AxisState::initialising && start_up_.state() == StartUp::State::following;
  bool is_safe = is_open || !controller::is_in_use(state_);
  if (!is_safe) {
    is_safe = Gate::approach(config_.gate, drive_, config_.gate.safe_drive,
                             config_.wipe_slew_per_s * input.dt_s, input.dt_s);
    if (closed_loop_) closed_loop_->follow(drive_);  // keeps the model's memory equal to the actuator's
  }
  state_ = is_safe ? AxisState::offline : AxisState::ready;
  if (!is_safe) return {.drive = drive_, .enable = true};
  start_up_.attempt_clear(false);
  return config_.safe_command();
}

}  // namespace hystcan::controller
