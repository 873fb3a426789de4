#include "controller/controller.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace hystcan::controller {
namespace {

/// From start() to the first SYNC: what is set up once in the event loop and its threads is set up by then.
constexpr auto warm_up = std::chrono::milliseconds(20);

/// Its nodes take part in every cycle: a sample is to come, and the command that answers it.
bool is_in_use(AxisState state) { return state > AxisState::waiting && state != AxisState::faulted; }

/// Of the drive's range: an amplifier that goes less from one status to the next rests.
constexpr double at_rest_within = 0.01;

/// Of an amplifier that does not report: it rests at its safe value, and obeys.
can::AmpStatus what_is_not_told(const AxisConfig& axis, const std::optional<can::MessageMap>& status) {
  can::AmpStatus believed;
  if (!status || !status->carries("output")) believed.output = axis.gate.safe_drive;
  if (!status || !status->carries("state")) believed.state = can::AmpState::enabled;
  return believed;
}

std::string_view refusal_of(LiveSetpoint became) {
  switch (became) {
    case LiveSetpoint::taken:
      return {};
    case LiveSetpoint::not_tracking:
      return "the axis does not track a reference";
    case LiveSetpoint::out_of_range:
      break;
  }
  return "the position is outside position_min_um..position_max_um, or of what the model reaches";
}

can::Checker checker_of(const can::Layout<can::AmpCommand>& layout) {
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

void Controller::lay_route(std::uint32_t id, bool extended, decltype(Route::handler) handler,
                           std::size_t index) {
  routes_.push_back({.id = id, .extended = extended, .handler = handler, .index = index});
}

template <Peer Controller::WiredAxis::*peer>
void Controller::lay_peer_routes(std::size_t index, decltype(Route::handler) on_heartbeat) {
  const std::uint32_t node = (axes_[index].get()->*peer).node();
  lay_route(can::heartbeat_base + node, false, on_heartbeat, index);
  lay_route(can::emergency_base + node, false, &Controller::on_emergency<peer>, index);
  lay_route(can::sdo_response_base + node, false, &Controller::on_sdo<peer>, index);
}

void Controller::lay_routes() {
  lay_route(can::sync_id, false, &Controller::on_foreign_sync, 0);
  lay_route(can::heartbeat_base + config_.node, false, &Controller::on_own_heartbeat, 0);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const WiredAxis& wired = *axes_[i];
    lay_route(wired.decode_sample.id(), wired.decode_sample.extended(), &Controller::on_sample, i);
    if (wired.decode_status)
      lay_route(wired.decode_status->id(), wired.decode_status->extended(), &Controller::on_status, i);
    lay_route(wired.encode_command.id(), wired.encode_command.extended(), &Controller::on_foreign_command, i);
    if (const auto id = wired.status_sender.id())
      lay_route(*id, false, &Controller::on_foreign_axis_status, i);
    if (wired.setpoint_receiver) lay_route(wired.setpoint_receiver->id(), false, &Controller::on_setpoint, i);
    lay_peer_routes<&WiredAxis::sensor>(i, &Controller::on_sensor_heartbeat);
    lay_peer_routes<&WiredAxis::amplifier>(i, &Controller::on_amplifier_heartbeat);
  }
  std::ranges::sort(routes_, {}, &Route::key);
}

/// A frame of the other identifier type in the place of a message goes to that message, which rejects and
/// counts it.
const Controller::Route* Controller::find_route(const can::Frame& frame) const {
  for (const bool extended : {frame.extended, !frame.extended}) {
    const auto key = std::pair(frame.id, extended);
    const auto found = std::ranges::lower_bound(routes_, key, {}, &Route::key);
    if (found != routes_.end() && found->key() == key) return &*found;
  }
  return nullptr;
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
  const auto add = [&](std::string message, const can::Checker& checker) {
    all.push_back(can::rejected_frames(std::move(message), checker));
  };
  all.reserve(9 * axes_.size());
  for (const auto& wired : axes_) {
    add(can::message_map<can::SensorSample>(wired->wire)->message, wired->decode_sample.checker());
    if (wired->decode_status)
      add(can::message_map<can::AmpStatus>(wired->wire)->message, wired->decode_status->checker());
    if (wired->setpoint_receiver)
      add(can::message_map<can::Setpoint>(wired->wire)->message, wired->setpoint_receiver->checker());
    for (const Peer* peer : {&wired->amplifier, &wired->sensor}) {
      const std::string node = std::to_string(peer->node());
      add("heartbeat of node " + node, peer->heartbeat_checker());
      add("emergency of node " + node, peer->emergency_checker());
      add("SDO response of node " + node, peer->sdo_checker());
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
  keep_house();

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

/// What has time, once a cycle: when the commands of all axes in use have been sent. The queue to the bus is
/// first in, first out, and short: what is put into it earlier holds the commands up, and what does not fit
/// is lost, so that beside the heartbeat there is one frame at most. Axis statuses and the set-up of nodes
/// take turns, nodes first where a heartbeat is due; a status goes before it, the least urgent frame of all.
void Controller::keep_house() {
  if (house_kept_) return;
  // From the back: samples come in the order of the axes, mostly, so that one look is enough before the last.
  const bool commands_sent = std::all_of(axes_.rbegin(), axes_.rend(), [](const auto& wired) {
    return wired->answered || !is_in_use(wired->axis.state());
  });
  if (!commands_sent) return;
  house_kept_ = true;
  answer_a_request();
  const bool beats = sync_sent_ >= next_heartbeat_;
  if (beats)
    for (const auto& wired : axes_) wired->status_sender.make_due();
  const bool wakes = beats && std::ranges::any_of(axes_, [](const auto& wired) {
                       return wired->axis.state() == AxisState::waiting;
                     });
  bool told = !told_last_cycle_ && !wakes && tell_of_an_axis();
  if (beats) {
    next_heartbeat_ = sync_sent_ + config_.heartbeat_period;
    bus_->send(can::heartbeat_frame(config_.node, can::NmtState::operational));
    if (next_to_wake_ >= node_count()) next_to_wake_ = 0;
  }
  if (!told && !set_up_a_node() && !wake_a_node()) told = tell_of_an_axis();
  told_last_cycle_ = told;
}

/// The next status that is due, of the axes in turn.
bool Controller::tell_of_an_axis() {
  for (std::size_t tried = 0; tried < axes_.size(); ++tried) {
    WiredAxis& wired = *axes_[next_to_tell_of_];
    next_to_tell_of_ = (next_to_tell_of_ + 1) % axes_.size();
    if (wired.status_sender.is_due(wired.axis)) return wired.status_sender.send(wired.axis, *bus_);
  }
  return false;
}

void Controller::answer_a_request() {
  if (requests_ == nullptr) return;
  Request* request = requests_->next();
  if (request == nullptr) return;
  request->refused_because = obey(*request);
  request->cycle = counters_.cycles;
  requests_->answer(request);
}

/// Why not; empty where it is done.
std::string_view Controller::obey(Request& request) {
  if (request.axis >= axes_.size()) return "there is no such axis";
  WiredAxis& wired = *axes_[request.axis];
  Axis& axis = wired.axis;
  switch (request.kind) {
    case Request::Kind::enable:
      if (axis.state() == AxisState::faulted) return "the axis is faulted: clear the fault first";
      if (axis.state() != AxisState::offline) return "the axis is enabled already";
      axis.start(false);
      return {};
    case Request::Kind::disable:
      if (axis.state() == AxisState::faulted || axis.state() == AxisState::offline)
        return "the axis is not enabled";
      axis.stop();
      return {};
    case Request::Kind::clear:
      if (!axis.clear()) return "there is no fault to clear";
      wired.sensor.retry_setup();
      wired.amplifier.retry_setup();
      return {};
    case Request::Kind::go_to:
      return refusal_of(axis.go_to(request.position_um));
    case Request::Kind::resume:
      return refusal_of(axis.resume());
    case Request::Kind::retune:
      return axis.retune(*request.tuning);
    case Request::Kind::revert:
      axis.revert_correction();
      return {};
    case Request::Kind::stop:
      request_stop();
      asked_to_stop_ = true;
      return {};
  }
  return "not a request";
}

/// Both nodes of each axis, sensors at the even places.
Peer& Controller::node_at(std::size_t place) {
  WiredAxis& wired = *axes_[place / 2];
  return place % 2 == 0 ? wired.sensor : wired.amplifier;
}

/// The next SDO request there is, of the nodes in turn; a node that cannot be set up is a fault of its axis.
bool Controller::set_up_a_node() {
  for (std::size_t tried = 0; tried < node_count(); ++tried) {
    const std::size_t place = next_to_set_up_;
    next_to_set_up_ = (place + 1) % node_count();
    Axis& axis = axes_[place / 2]->axis;
    if (axis.state() != AxisState::waiting) continue;
    Peer& node = node_at(place);
    const auto request = node.poll_setup(scheduler_.now());
    if (node.setup_has_failed()) axis.trip(Cause::node_not_set_up, can::seconds(sync_sent_ - started_));
    if (!request) continue;
    bus_->send(*request);
    return true;
  }
  return false;
}

/// Nodes that wait in pre-operational are started once they are set up: each once in a period of the
/// heartbeat.
bool Controller::wake_a_node() {
  while (next_to_wake_ < node_count()) {
    const std::size_t place = next_to_wake_++;
    if (axes_[place / 2]->axis.state() == AxisState::waiting && wake(node_at(place))) return true;
  }
  return false;
}

bool Controller::wake(const Peer& peer) {
  const auto state = peer.state(scheduler_.now());
  if (peer.is_set_up() && state != can::NmtState::operational)
    return bus_->send(can::nmt_frame({can::NmtCommand::start, peer.node()}));
  if (!peer.is_set_up() && state == can::NmtState::stopped)
    return bus_->send(can::nmt_frame({can::NmtCommand::enter_pre_operational, peer.node()}));
  return false;
}

void Controller::handle(const can::Frame& frame) {
  if (const Route* route = find_route(frame)) (this->*route->handler)(route->index, frame);
}

/// Our own frames never come back to us: one that bears our identifier is somebody else's.
void Controller::hear_another() {
  if (phase_ != Phase::listening && phase_ != Phase::running) return;
  for (const auto& wired : axes_)
    if (wired->axis.state() != AxisState::offline)
      wired->axis.trip(Cause::another_controller, can::seconds(scheduler_.now() - started_));
  if (phase_ == Phase::listening) keep_silent();
}

/// The other one may be driving: not even a safe command of ours may come between. What is left to do is to
/// tell.
void Controller::keep_silent() {
  phase_ = Phase::silent;
  sync_timer_->cancel();
  sync_sent_ = scheduler_.now();
  for (std::size_t i = 0; i < axes_.size(); ++i) step(i, nullptr);
}

void Controller::on_own_heartbeat(std::size_t, const can::Frame& frame) {
  if (can::is_heartbeat_of(config_.node, frame)) hear_another();
}

void Controller::on_foreign_sync(std::size_t, const can::Frame& frame) {
  if (can::parse_sync(frame)) hear_another();
}

/// A damaged one, which the amplifier does not take either, is nobody's.
void Controller::on_foreign_command(std::size_t index, const can::Frame& frame) {
  if (!axes_[index]->foreign_command.check(frame)) hear_another();
}

void Controller::on_foreign_axis_status(std::size_t index, const can::Frame& frame) {
  if (axes_[index]->status_sender.is_sound(frame)) hear_another();
}

void Controller::on_setpoint(std::size_t index, const can::Frame& frame) {
  axes_[index]->setpoint_receiver->hear(frame, axes_[index]->axis);
}

void Controller::on_bus_state(can::BusState state) {
  if (state != can::BusState::bus_off && state != can::BusState::down) return;
  for (const auto& wired : axes_) {
    wired->bus_off_seen |= state == can::BusState::bus_off;
    wired->sensor.forget();
    wired->amplifier.forget();
    wired->decode_sample.restart();
    if (wired->decode_status) wired->decode_status->restart();
    wired->status = {};
  }
}

void Controller::on_sample(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const auto sample = wired.decode_sample(frame);
  if (!sample) return;
  const bool of_another_cycle = wired.samples_name_their_sync && sample->sync_counter != sync_counter_;
  if (of_another_cycle || wired.answered) {
    ++counters_.late_samples;
    wired.late_sample = true;
    return;
  }
  step(index, &*sample);
  keep_house();
}

void Controller::on_status(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const auto status = (*wired.decode_status)(frame);
  if (!status) return;
  wired.amplifier_moves = tells_of_a_move(wired, *status);
  wired.status = *status;
  if (wired.flags_tell_fault && status->fault != 0) wired.status.state = can::AmpState::fault;
}

/// As it is switched off it still tells the drive that it leaves.
bool Controller::tells_of_a_move(const WiredAxis& wired, const can::AmpStatus& status) {
  const bool was_enabled = wired.status.state == can::AmpState::enabled;
  if (was_enabled && status.state != can::AmpState::enabled) return true;
  const Gate::Config& gate = wired.axis.config().gate;
  return std::abs(status.output - wired.status.output) > at_rest_within * (gate.drive_max - gate.drive_min);
}

void Controller::on_sensor_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  if (wired.sensor.hear_heartbeat(frame, scheduler_.now())) wired.decode_sample.restart();
}

void Controller::on_amplifier_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const bool booted = wired.amplifier.hear_heartbeat(frame, scheduler_.now());
  if (booted && wired.decode_status) wired.decode_status->restart();
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
