#include "controller/controller.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace hystcan::controller {
namespace {

/// Minimum time from start() to the first SYNC: the event loop and its threads finish their own set-up.
constexpr auto warm_up = std::chrono::milliseconds(20);

void check_couplings(const Config& config) {
  for (const WiredAxisConfig& axis : config.axes)
    for (const model::Coupling& coupling : axis.axis.couplings)
      if (coupling.index >= config.axes.size())
        throw std::invalid_argument("axis " + axis.wire.name + " has a coupling from " + coupling.from +
                                    ", expected the name of a controlled axis");
}

}  // namespace

can::Duration cycle_of(const CommonConfig& config) {
  return can::Duration(std::llround(1e9 / config.rate_Hz));
}

can::Duration command_deadline_of(const CommonConfig& config) {
  if (config.command_deadline > can::Duration::zero()) return config.command_deadline;
  return 9 * cycle_of(config) / 10;
}

Controller::Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                       const can::Attach& attach, RecordHandler on_record)
    : config_(config),
      scheduler_(scheduler),
      on_record_(std::move(on_record)),
      background_(config.node, config.heartbeat_period, config.background_slots, axes_),
      sync_timer_(scheduler.make_timer([this] { tick(); })),
      clock_(cycle_of(config)),
      together_({.waits = config.start_together, .timeout = config.start_timeout}) {
  check_couplings(config);
  make_axes(config, database);
  add_handlers();
  std::vector<can::Filter> filters;
  for (auto at = handlers_.begin(); at != handlers_.end(); at = handlers_.upper_bound(at->first))
    filters.push_back({.id = at->first.first, .extended = at->first.second});
  bus_ = attach(filters);
  bus_->on_frame([this](const can::Frame& frame, can::Time heard) { pass_on(frame, heard); });
  bus_->on_state([this](can::BusState state) { on_bus_state(state); });
  const bool reports_echoes = bus_->on_sent([this](const can::Frame& frame, can::Time) {
    for (const auto& commands : frames_.commands)
      commands->on_echo(frame, clock_.cycle().sync_counter, *bus_);
  });
  if (!reports_echoes) return;
  for (const auto& commands : frames_.commands) commands->begin_to_count_echoes();
}

/// Makes the axes. Axes whose commands are in the same message share its frame.
void Controller::make_axes(const Config& config, const can::Database& database) {
  axes_.reserve(config.axes.size());
  for (const WiredAxisConfig& axis : config.axes)
    axes_.push_back(
        std::make_unique<WiredAxis>(axis, axes_.size(), config.heartbeat_timeout, database, frames_));
  for (const RestingAxis& axis : config.resting) {
    const auto layout = can::find_layout<can::AmpCommand>(database, axis.wire);
    if (CommandFrame* commands = find_frame(frames_.commands, *layout))
      commands->rest(*layout, axis.safe_drive);
  }
  if (frames_.commands.size() == axes_.size()) return;
  config_.command_deadline = command_deadline_of(config);
  command_timer_ = scheduler_.make_timer([this] { end_waiting(); });
}

/// Passes a frame to the handlers of its identifier. If there are none, passes it to the handlers of the same
/// identifier of the other type (standard or extended), which reject and count the frame.
void Controller::pass_on(const can::Frame& frame, can::Time heard) const {
  auto [handler, end] = handlers_.equal_range({frame.id, frame.extended});
  if (handler == end) std::tie(handler, end) = handlers_.equal_range({frame.id, !frame.extended});
  for (; handler != end; ++handler) handler->second(frame, heard);
}

/// Adds the handlers of all received frames. The bus never returns our own frames, so a frame with one of our
/// identifiers is from another controller. A damaged frame, which no node accepts, is ignored.
void Controller::add_handlers() {
  add_handler(can::sync_id, false, [this](const can::Frame& frame, can::Time) {
    if (can::is_sync(frame)) on_another_controller(ForeignFrame::Kind::sync, frame);
  });
  add_handler(can::nmt_id, false, [this](const can::Frame& frame, can::Time) { on_foreign_nmt(frame); });
  add_handler(can::heartbeat_base + config_.node, false, [this](const can::Frame& frame, can::Time) {
    if (can::is_heartbeat_of(config_.node, frame))
      on_another_controller(ForeignFrame::Kind::heartbeat, frame);
  });
  for (const auto& commands : frames_.commands)
    add_handler(commands->id(), commands->extended(), [this, &commands](const can::Frame& frame, can::Time) {
      if (commands->is_sound(frame)) on_another_controller(ForeignFrame::Kind::command, frame);
    });
  for (const auto& wired : axes_) add_handlers_of(*wired);
  for (const auto& samples : frames_.samples)
    add_handler(
        samples->id(), samples->extended(),
        [this, &samples](const can::Frame& frame, can::Time heard) { on_samples(*samples, frame, heard); });
  for (const auto& statuses : frames_.statuses)
    add_handler(statuses->id(), statuses->extended(),
                [this, &statuses](const can::Frame& frame, can::Time) { on_statuses(*statuses, frame); });
}

void Controller::add_handlers_of(WiredAxis& wired) {
  if (const auto id = wired.status_sender.id())
    add_handler(*id, false, [this, &wired](const can::Frame& frame, can::Time) {
      if (wired.status_sender.is_sound(frame)) on_another_controller(ForeignFrame::Kind::axis_status, frame);
    });
  if (const auto& receiver = wired.setpoint_receiver)
    add_handler(receiver->id(), false, [&wired](const can::Frame& frame, can::Time) {
      wired.setpoint_receiver->on_frame(frame, wired.axis);
    });
  add_handler(can::heartbeat_base + wired.sensor.node(), false,
              [this, &wired](const can::Frame& frame, can::Time) {
                if (wired.sensor.on_heartbeat(frame, scheduler_.now()) == Heartbeat::as_before)
                  judge_slot(wired.sensor);
              });
  add_handler(can::heartbeat_base + wired.amplifier.node(), false,
              [this, &wired](const can::Frame& frame, can::Time) {
                if (wired.amplifier.on_heartbeat(frame, scheduler_.now()) == Heartbeat::as_before)
                  judge_slot(wired.amplifier);
              });
  for (RemoteNode* node : wired.nodes()) {
    add_handler(can::emergency_base + node->node(), false,
                [node](const can::Frame& frame, can::Time) { node->on_emergency(frame); });
    add_handler(can::sdo_response_base + node->node(), false,
                [node](const can::Frame& frame, can::Time) { node->on_sdo(frame); });
    add_handler(can::sdo_request_base + node->node(), false,
                [this, node, &wired](const can::Frame& frame, can::Time) {
                  if (node->on_foreign_sdo(frame)) trip_if_in_use(wired, Cause::foreign_access);
                });
  }
}

void Controller::start(bool clear_amplifier_faults) {
  clock_.start(scheduler_.now(), std::max<can::Duration>(warm_up, config_.heartbeat_period));
  phase_ = Phase::listening;
  for (const auto& wired : axes_) wired->axis.start(clear_amplifier_faults);
  sync_timer_->expire_at(clock_.deadline());
}

void Controller::request_stop() {
  for (const auto& wired : axes_) wired->axis.stop();
}

bool Controller::stopped() const {
  return std::ranges::all_of(axes_, [](const auto& wired) {
    return !wired->axis.is_in_use() && wired->axis.state() != AxisState::waiting;
  });
}

void Controller::send_safe_commands() {
  if (phase_ != Phase::running) return;
  for (const auto& wired : axes_)
    wired->amplifier.put(AxisCommand{.drive = wired->axis.config().gate.safe_drive},
                         clock_.cycle().sync_counter);
  for (const auto& commands : frames_.commands) {
    commands->forget();  // so that send() sends at once, without waiting for the echo of the last frame
    commands->send(*bus_);
  }
}

std::vector<std::string> Controller::node_notes() const {
  std::vector<std::string> lines;
  const auto add = [&](const RemoteNode& node, const std::string& text) {
    std::string line = "node " + std::to_string(node.node()) + ": " + text;
    if (std::ranges::find(lines, line) == lines.end()) lines.push_back(std::move(line));
  };
  for (const auto& wired : axes_)
    for (const RemoteNode* node :
         std::initializer_list<const RemoteNode*>{&wired->amplifier, &wired->sensor}) {
      if (const std::string text = describe(node->foreign_access()); !text.empty()) add(*node, text);
      if (const std::uint64_t frames = node->outside_slot(); frames != 0)
        add(*node, std::to_string(frames) + " heartbeats and statuses outside the slot of the node");
    }
  return lines;
}

std::vector<can::RejectedFrames> Controller::rejected() const {
  std::vector<can::RejectedFrames> all;
  all.reserve(9 * axes_.size());
  std::set<std::uint8_t> nodes;
  for (const auto& wired : axes_) wired->append_rejected(all, nodes);
  return all;
}

void Controller::tick() {
  if (phase_ == Phase::silent) return;
  if (phase_ == Phase::listening) {
    phase_ = Phase::running;
    background_.start(*bus_, scheduler_.now());
  }
  close_cycle();
  begin_cycle(scheduler_.now());
  run_background_tasks();
  sync_timer_->expire_at(clock_.deadline());
}

/// Sends the command frames of this cycle that are not sent yet. Axes whose sample has not arrived step
/// without it.
void Controller::close_cycle() {
  for (const auto& commands : frames_.commands)
    if (!commands->is_answered()) answer(*commands);
}

void Controller::begin_cycle(can::Time now) {
  clock_.begin_cycle(now);
  const Cycle& cycle = clock_.cycle();
  counters_.missed_cycles = clock_.missed_cycles();
  together_.step(axes_, now, clock_.since_start_s(now - clock_.waited()));
  timing_.lateness.add(cycle.lateness);
  if (counters_.cycles != 0) timing_.period.add(cycle.sync_period);  // the first SYNC has no period
  // A SYNC that is too late shows that the computer misses its deadlines.
  if (config_.lateness_trip != can::Duration::zero() && cycle.lateness > config_.lateness_trip)
    for (const auto& wired : axes_) trip_if_in_use(*wired, Cause::cycle_overrun);
  bus_->send(can::sync_frame(cycle.sync_counter));
  background_.begin_cycle(*bus_, cycle.sync_counter, now);
  ++counters_.cycles;
  for (const auto& commands : frames_.commands) commands->begin_cycle();
  if (command_timer_) command_timer_->expire_at(now + config_.command_deadline);
  for (const auto& wired : axes_)
    wired->axis.prepare(clock_.time_s() - can::seconds(clock_.waited()), can::seconds(clock_.period()));
}

void Controller::trip_if_in_use(WiredAxis& wired, Cause cause) {
  if (wired.axis.is_in_use()) wired.axis.trip(cause, clock_.since_start_s(scheduler_.now()));
}

/// Runs the less urgent tasks once per cycle, when the commands of all axes in use have been sent.
void Controller::run_background_tasks() {
  if (background_.is_done()) return;
  // Tests the last axis first: samples mostly arrive in the order of the axes, so that one test is mostly
  // enough. An axis that has faulted since its last step still has to send its safe command.
  const bool commands_sent = std::all_of(axes_.rbegin(), axes_.rend(), [](const auto& wired) {
    return wired->amplifier.commands().is_answered() || !is_in_use(wired->axis.report().state);
  });
  if (!commands_sent) return;
  answer_next_request();
  background_.send_next(*bus_, clock_.cycle().sync_sent, scheduler_.now(), clock_.time_s());
}

void Controller::answer_next_request() {
  Request* request = requests_ == nullptr ? nullptr : requests_->next();
  if (request == nullptr) return;
  request->refusal = carry_out(*request, axes_);
  request->cycle = counters_.cycles;
  asked_to_stop_ |= request->kind == Request::Kind::stop && !request->refusal;
  requests_->answer(request);
}

/// Handles a frame with statuses. A new state of an amplifier may arrive at any time. All other statuses must
/// arrive in the slot of their node (can::is_in_slot).
void Controller::on_statuses(ReceivedFrame& statuses, const can::Frame& frame) {
  if (!statuses.accepts(frame)) return;
  bool nothing_new = true;
  for (const std::size_t i : statuses.axes())
    nothing_new &= axes_[i]->amplifier.on_status(frame, scheduler_.now());
  if (!nothing_new) return;
  for (const std::size_t i : statuses.axes()) judge_slot(axes_[i]->amplifier);
}

/// Checks the slot of a frame, except in the first `slots` cycles: the node may not know its slot yet.
void Controller::judge_slot(RemoteNode& node) const {
  const unsigned slots = config_.background_slots;
  if (slots != 0 && counters_.cycles > slots) node.note_background_frame(clock_.cycle().sync_counter, slots);
}

/// Handles a frame with samples: steps all axes of the frame, then sends their commands.
void Controller::on_samples(SampleFrame& samples, const can::Frame& frame, can::Time heard) {
  if (!samples.accepts(frame)) return;
  for (const std::size_t i : samples.axes()) take_sample(*axes_[i], frame, heard);
  bool has_answered = false;
  for (const std::size_t i : samples.axes()) {
    CommandFrame& commands = axes_[i]->amplifier.commands();
    if (commands.is_answered() || !axes_[i]->amplifier.is_commanded() ||
        std::ranges::any_of(commands.axes(), [this](std::size_t k) { return is_awaited(*axes_[k]); }))
      continue;
    answer(commands);
    has_answered = true;
  }
  if (has_answered) run_background_tasks();
}

/// Steps the axis if the sample is from this cycle and the axis has not been stepped without it.
void Controller::take_sample(WiredAxis& wired, const can::Frame& frame, can::Time heard) {
  const auto sample = wired.sensor.on_sample(frame, counters_.cycles);
  if (!sample) return;
  if (wired.sensor.is_doubled()) trip_if_in_use(wired, Cause::sample_doubled);
  const bool is_of_this_cycle = wired.sensor.is_of(*sample, clock_.cycle().sync_counter);
  if (is_of_this_cycle && (!command_timer_ || heard - clock_.cycle().sync_sent < config_.command_deadline))
    wired.sensor.note_sample_in_time(counters_.cycles);
  if (wired.amplifier.is_commanded() || !is_of_this_cycle) {
    ++counters_.late_samples;
    wired.sensor.note_late_sample();
    return;
  }
  step(wired, &*sample, heard);
}

bool Controller::is_awaited(const WiredAxis& wired) const {
  return !wired.amplifier.is_commanded() &&
         wired.sensor.is_awaited(counters_.cycles, wired.axis.config().supervision.missing_samples);
}

/// Called at the command deadline. Sends each command frame of several axes that is not sent yet, because a
/// sample is missing.
void Controller::end_waiting() {
  if (phase_ == Phase::silent) return;
  for (const auto& commands : frames_.commands)
    if (commands->axes().size() > 1 && !commands->is_answered()) answer(*commands);
  run_background_tasks();
}

/// Steps each axis of the frame whose sample is missing, then sends the commands of all its axes. The rest of
/// the work of the cycle follows the command.
void Controller::answer(CommandFrame& commands) {
  for (const std::size_t i : commands.axes()) {
    if (axes_[i]->amplifier.is_commanded()) continue;
    if (axes_[i]->axis.state() > AxisState::waiting) ++counters_.missing_samples;
    step(*axes_[i], nullptr);
  }
  if (phase_ == Phase::running && commands.send(*bus_)) ++counters_.replaced_commands;
  commands.end_cycle();
  for (const std::size_t i : commands.axes()) {
    axes_[i]->phases.command_sent = scheduler_.now() - clock_.cycle().sync_sent;
    record(*axes_[i]);
    axes_[i]->axis.finish();
  }
}

/// Steps the axis and puts its command into its frame.
void Controller::step(WiredAxis& wired, const can::SensorSample* sample, can::Time heard) {
  const Cycle& cycle = clock_.cycle();
  wired.phases = {.period = cycle.sync_period, .lateness = cycle.lateness};
  if (sample != nullptr) wired.phases.sample_heard = heard - cycle.sync_sent;
  const can::Time begun = scheduler_.now();  // one clock reading, used twice: each costs 0.17 us in the VM
  const AxisCommand command = wired.axis.decide(input_of(wired, sample, begun));
  wired.phases.execution = scheduler_.now() - begun;
  if (auto& marker = wired.scan_marker_sender) marker->note(wired.axis.report(), cycle.sync_counter);
  const bool is_asleep = wired.axis.state() == AxisState::waiting &&
                         wired.amplifier.state(cycle.sync_sent) != can::NmtState::operational;
  const bool fits =
      wired.amplifier.put(is_asleep ? std::optional<AxisCommand>{} : command, cycle.sync_counter);
  if (!fits && phase_ == Phase::running) wired.axis.trip(Cause::command_not_sendable, clock_.time_s());
}

AxisInput Controller::input_of(WiredAxis& wired, const can::SensorSample* sample, can::Time now) const {
  AxisInput input{.time_s = clock_.time_s(),
                  .dt_s = clock_.cycle().dt_s,
                  .cycle_s = can::seconds(clock_.period()),
                  .waited_s = can::seconds(clock_.waited()),
                  .position_um = std::nullopt,
                  .tracking_since_s = together_.tracking_since_s(),
                  .health = {}};
  wired.sensor.take_health(now, input);
  wired.amplifier.take_health(now, bus_->state(), input);
  if (sample != nullptr) {
    input.position_um = sample->position_um;
    input.sensor_status_good = sample->status == 0;
  }
  // Adds the coupling from the other axes at the time when the command takes effect.
  ClosedLoop* loop = wired.axis.closed_loop();
  const double acts_s = input.reference_time_s() + (loop == nullptr ? 0.0 : loop->preview_s(input.cycle_s));
  for (const model::Coupling& coupling : wired.axis.config().couplings)
    input.coupled_um += coupling.um_per_um * axes_[coupling.index]->axis.expected_um(acts_s);
  return input;
}

void Controller::record(WiredAxis& wired) {
  const CyclePhases& phases = wired.phases;
  timing_.execution.add(phases.execution);
  if (phases.sample_heard != can::Duration::zero()) timing_.turnaround.add(phases.turnaround());
  on_record_({.cycle = counters_.cycles,
              .time_s = clock_.time_s(),
              .axis = wired.index,
              .report = wired.axis.report(),
              .amplifier_output = wired.amplifier.output(),
              .amplifier_output_age_s = wired.amplifier.output_age_s(clock_.cycle().sync_sent),
              .phases = phases,
              .counters = counters_,
              .event = wired.take_event()});
}

void Controller::on_foreign_nmt(const can::Frame& frame) {
  for (const auto& wired : axes_)
    for (RemoteNode* node : wired->nodes())
      if (node->on_foreign_nmt(frame)) trip_if_in_use(*wired, Cause::foreign_access);
}

void Controller::on_another_controller(ForeignFrame::Kind kind, const can::Frame& frame) {
  if (phase_ != Phase::listening && phase_ != Phase::running) return;
  for (const auto& wired : axes_)
    wired->on_another_controller({.kind = kind, .id = frame.id, .extended = frame.extended},
                                 clock_.since_start_s(scheduler_.now()));
  if (phase_ == Phase::listening) keep_silent();
}

/// Stops sending permanently: another controller may be driving the stage, and even a safe command of ours
/// could interfere. The axes make one more step, only for the last records.
void Controller::keep_silent() {
  phase_ = Phase::silent;
  sync_timer_->cancel();
  clock_.end(scheduler_.now());
  for (const auto& wired : axes_) step(*wired, nullptr);
  for (const auto& commands : frames_.commands) answer(*commands);
}

void Controller::on_bus_state(can::BusState state) {
  if (state != can::BusState::bus_off && state != can::BusState::down) return;
  for (const auto& wired : axes_) {
    wired->sensor.on_bus_loss();
    wired->amplifier.on_bus_loss(state);
  }
}

}  // namespace hystcan::controller
