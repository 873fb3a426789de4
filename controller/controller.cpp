#include "controller/controller.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::controller {
namespace {

/// From start() to the first SYNC: what is set up once in the event loop and its threads is set up by then.
constexpr auto warm_up = std::chrono::milliseconds(20);

/// Of an amplifier that does not report: it rests at its safe value, and obeys.
can::AmpStatus what_is_not_told(const AxisConfig& axis, const std::optional<can::MessageMap>& status) {
  can::AmpStatus believed;
  if (!status || !status->carries("output")) believed.output = axis.gate.safe_drive;
  if (!status || !status->carries("state")) believed.state = can::AmpState::enabled;
  return believed;
}

can::E2eChecker checker_of(const can::Layout<can::AmpCommand>& layout) {
  return {layout.protection(), layout.length(), layout.extended()};
}

}  // namespace

Controller::WiredAxis::WiredAxis(const WiredAxisConfig& config, const Config& common,
                                 const can::Database& database)
    : wire(config.wire),
      axis(config.axis),
      decode_sample(*can::find_layout<can::SensorSample>(database, wire)),
      encode_command(*can::find_layout<can::AmpCommand>(database, wire)),
      samples_name_their_sync(can::message_map<can::SensorSample>(wire)->carries("sync_counter")),
      flags_tell_fault(false),
      foreign_command(checker_of(*can::find_layout<can::AmpCommand>(database, wire))),
      status_sender(database, wire),
      sensor(wire.sensor_node, common.heartbeat_timeout, {wire.sensor_setup, wire.setup_patience}),
      amplifier(wire.amplifier_node, common.heartbeat_timeout, {wire.amplifier_setup, wire.setup_patience}) {
  const auto map = can::message_map<can::AmpStatus>(wire);
  const can::AmpStatus believed = what_is_not_told(config.axis, map);
  if (auto layout = can::find_layout<can::AmpStatus>(database, wire, believed))
    decode_status.emplace(std::move(*layout));
  else
    status = believed;
  if (config.live_setpoint) setpoint_receiver.emplace(database, wire);
  flags_tell_fault = map && (!map->carries("state") || map->states.fault.empty());
}

Controller::Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                       const can::Attach& attach, RecordHandler on_record)
    : config_(config),
      scheduler_(scheduler),
      on_record_(std::move(on_record)),
      sync_timer_(scheduler.make_timer([this] { tick(); })),
      period_(std::llround(1e9 / config.rate_Hz)) {
  axes_.reserve(config.axes.size());
  for (const WiredAxisConfig& axis : config.axes)
    for (const Coupling& coupling : axis.axis.couplings)
      if (coupling.index >= config.axes.size())
        throw std::invalid_argument("axis " + axis.axis.name + " is coupled with " + coupling.from +
                                    ", expected one of the axes that are controlled");
  for (const WiredAxisConfig& axis : config.axes)
    axes_.push_back(std::make_unique<WiredAxis>(axis, config, database));
  lay_routes();
  std::vector<can::Filter> filters;
  filters.reserve(routes_.size());
  for (const Route& route : routes_) filters.push_back({.id = route.id, .extended = route.extended});
  bus_ = attach(filters);
  bus_->on_frame([this](const can::Frame& frame, can::Time received) {
    heard_ = received;
    handle(frame);
  });
  bus_->on_state([this](can::BusState state) { on_bus_state(state); });
}

void Controller::start(bool clear_amplifier_faults) {
  started_ = scheduler_.now();
  sync_sent_ = started_;
  deadline_ = started_ + std::max<can::Duration>(warm_up, config_.heartbeat_period);
  phase_ = Phase::listening;
  for (const auto& wired : axes_) wired->axis.start(clear_amplifier_faults);
  sync_timer_->expire_at(deadline_);
}

void Controller::request_stop() {
  for (const auto& wired : axes_) wired->axis.stop();
}

bool Controller::stopped() const {
  return std::ranges::all_of(axes_, [](const auto& wired) {
    return wired->axis.state() == AxisState::offline || wired->axis.state() == AxisState::faulted;
  });
}

void Controller::send_safe_commands() {
  for (const auto& wired : axes_) send_command(*wired, {.drive = wired->axis.config().gate.safe_drive});
}

std::optional<SetpointCounters> Controller::live_setpoints(std::size_t i) const {
  if (!axes_[i]->setpoint_receiver) return std::nullopt;
  return axes_[i]->setpoint_receiver->counters();
}

std::vector<can::RejectedFrames> Controller::rejected() const {
  std::vector<can::RejectedFrames> all;
  const auto add = [&](std::string message, const can::E2eChecker& checker) {
    all.push_back(can::rejected_frames(std::move(message), checker));
  };
  all.reserve(9 * axes_.size());
  for (const auto& wired : axes_) {
    add(can::message_map<can::SensorSample>(wired->wire)->message, wired->decode_sample.checker());
    if (wired->decode_status)
      add(can::message_map<can::AmpStatus>(wired->wire)->message, wired->decode_status->checker());
    if (wired->setpoint_receiver)
      add(can::message_map<can::Setpoint>(wired->wire)->message, wired->setpoint_receiver->checker());
    for (const RemoteNode* node : {&wired->amplifier, &wired->sensor}) {
      const std::string number = std::to_string(node->node());
      add("heartbeat of node " + number, node->heartbeat_checker());
      add("emergency of node " + number, node->emergency_checker());
      add("SDO response of node " + number, node->sdo_checker());
    }
  }
  return all;
}

void Controller::tick() {
  if (phase_ == Phase::silent) return;
  if (phase_ == Phase::listening) {
    phase_ = Phase::running;
    next_heartbeat_ = scheduler_.now() + config_.heartbeat_period;
    bus_->send(can::heartbeat_frame(config_.node, can::NmtState::boot_up));
  }
  close_cycle();
  begin_tracking_ = std::ranges::all_of(axes_, [](const auto& wired) {
    const AxisState state = wired->axis.state();
    return state == AxisState::ready || state == AxisState::tracking;
  });

  const can::Time now = scheduler_.now();
  note_wake_up(now);
  dt_s_ = can::seconds(now - sync_sent_);
  sync_sent_ = now;
  sync_counter_ = can::next_sync_counter(sync_counter_);
  bus_->send(can::sync_frame(sync_counter_));
  ++counters_.cycles;
  for (const auto& wired : axes_) wired->answered = false;
  house_kept_ = false;
  run_background_tasks();

  deadline_ += period_;
  while (deadline_ <= now) {  // re-align: a missed deadline is left out, never caught up with
    deadline_ += period_;
    ++counters_.overruns;
  }
  sync_timer_->expire_at(deadline_);
}

/// A SYNC that comes too late tells of a computer that does not keep its time.
void Controller::note_wake_up(can::Time now) {
  sync_late_ = now - deadline_;
  timing_.wake_up.add(sync_late_);
  if (counters_.cycles != 0) {  // the first SYNC has none before it
    sync_period_ = now - sync_sent_;
    timing_.period.add(sync_period_);
  }
  if (config_.wake_up_trip == can::Duration::zero() || sync_late_ <= config_.wake_up_trip) return;
  for (const auto& wired : axes_)
    if (is_in_use(wired->axis.state())) wired->axis.trip(Cause::cycle_overrun, can::seconds(now - started_));
}

/// Axes whose sample has not come are stepped without it.
void Controller::close_cycle() {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i]->answered) continue;
    if (axes_[i]->axis.state() > AxisState::waiting) ++counters_.missing_samples;
    step(i, nullptr);
  }
}

void Controller::step(std::size_t index, const can::SensorSample* sample) {
  WiredAxis& wired = *axes_[index];
  wired.answered = true;
  AxisInput input{.time_s = can::seconds(sync_sent_ - started_),
                  .dt_s = dt_s_,
                  .cycle_s = can::seconds(period_),
                  .position_um = std::nullopt,
                  .late_sample = std::exchange(wired.late_sample, false),
                  .begin_tracking = begin_tracking_,
                  .health = health(wired)};
  if (sample != nullptr) {
    input.position_um = sample->position_um;
    input.sensor_status_good = sample->status == 0;
  }
  input.coupled_um = coupled_um(wired.axis, input);
  const can::Time begun = scheduler_.now();
  const AxisCommand command = wired.axis.step(input);
  const can::Time decided = scheduler_.now();
  const bool is_asleep = wired.axis.state() == AxisState::waiting &&
                         wired.amplifier.state(sync_sent_) != can::NmtState::operational;
  if (!is_asleep) send_command(wired, command);
  auto event = wired.amplifier.take_event();
  if (!event) event = wired.sensor.take_event();
  const can::Time sent = scheduler_.now();
  const can::Time heard = sample != nullptr ? heard_ : sent;
  timing_.execution.add(decided - begun);
  if (sample != nullptr) timing_.turnaround.add(sent - heard);
  on_record_({.cycle = counters_.cycles,
              .time_s = input.time_s,
              .axis = index,
              .report = wired.axis.report(),
              .amplifier_output = wired.status.output,
              .turnaround = sent - heard,
              .phases = {.period = sync_period_,
                         .lateness = sync_late_,
                         .sample_heard = sample != nullptr ? heard - sync_sent_ : can::Duration::zero(),
                         .command_sent = sent - sync_sent_,
                         .execution = decided - begun},
              .counters = counters_,
              .event = event});
}

/// What the other axes will add to this one's position when the command acts.
double Controller::coupled_um(Axis& axis, const AxisInput& input) const {
  double sum_um = 0.0;
  for (const Coupling& coupling : axis.config().couplings)
    sum_um += coupling.um_per_um *
              axes_[coupling.index]->axis.expected_um(input.time_s + axis.preview_s(input.cycle_s));
  return sum_um;
}

void Controller::send_command(WiredAxis& wired, const AxisCommand& command) {
  if (phase_ != Phase::running) return;
  const auto frame = wired.encode_command({.setpoint = command.drive,
                                           .enable = command.enable,
                                           .clear_fault = command.clear_fault,
                                           .sync_counter = sync_counter_});
  wired.amplifier_moves |= command.enable && wired.decode_status.has_value();
  if (frame)
    bus_->send(*frame);
  else  // the amplifier's watchdog acts on the silence
    wired.axis.trip(Cause::command_not_sendable, can::seconds(sync_sent_ - started_));
}

NodeHealth Controller::health(WiredAxis& wired) const {
  const can::Time now = scheduler_.now();
  const unsigned boot_ups = wired.sensor.boot_ups() + wired.amplifier.boot_ups();
  const bool restarted = std::exchange(wired.boot_ups_seen, boot_ups) != boot_ups;
  const bool sensor_emergency = wired.sensor.take_alarm();
  const bool emergency = wired.amplifier.take_alarm() || sensor_emergency;
  const bool was_off = std::exchange(wired.bus_off_seen, false);
  return {.interface_up = bus_->state() != can::BusState::down,
          .bus_on = bus_->state() != can::BusState::bus_off && !was_off,
          .bus_passive = bus_->state() == can::BusState::passive,
          .sensor_alive = wired.sensor.state(now).has_value(),
          .sensor_operational = wired.sensor.is_operational(now),
          .amplifier_alive = wired.amplifier.state(now).has_value(),
          .amplifier_operational = wired.amplifier.is_operational(now),
          .restarted = restarted,
          .emergency = emergency,
          .amplifier_ready =
              wired.status.state == can::AmpState::ready || wired.status.state == can::AmpState::enabled,
          .amplifier_enabled = wired.status.state == can::AmpState::enabled,
          .amplifier_fault = wired.status.state == can::AmpState::fault,
          .amplifier_output = wired.status.output,
          .amplifier_moves = wired.amplifier_moves};
}

}  // namespace hystcan::controller
