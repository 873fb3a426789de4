#include "controller/controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hystcan::controller {
namespace {

/// From start() to the first SYNC: what is set up once in the event loop and its threads is set up by then.
constexpr auto warm_up = std::chrono::milliseconds(20);

}  // namespace

Controller::WiredAxis::WiredAxis(const WiredAxisConfig& config, const Config& common,
                                 const can::Database& database)
    : wire(config.wire),
      axis(config.axis),
      decode_sample(can::find_message<can::SensorSample>(database, wire)),
      decode_status(can::find_message<can::AmpStatus>(database, wire)),
      encode_command(can::find_message<can::AmpCommand>(database, wire)),
      sensor_heartbeat(common.heartbeat_timeout),
      amplifier_heartbeat(common.heartbeat_timeout) {}

Controller::Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
                       const can::Attach& attach, RecordHandler on_record)
    : config_(config),
      scheduler_(scheduler),
      on_record_(std::move(on_record)),
      sync_timer_(scheduler.make_timer([this] { tick(); })),
      period_(std::llround(1e9 / config.rate_Hz)) {
  std::vector<can::Filter> filters;
  const auto route = [&](std::uint32_t id, decltype(Route::handler) handler) {
    filters.push_back({.id = id});
    routes_.at(id) = {handler, axes_.size()};
  };
  for (const WiredAxisConfig& axis : config.axes) {
    auto wired = std::make_unique<WiredAxis>(axis, config, database);
    route(wired->decode_sample.id(), &Controller::on_sample);
    route(wired->decode_status.id(), &Controller::on_status);
    route(can::heartbeat_base + axis.wire.sensor_node, &Controller::on_sensor_heartbeat);
    route(can::heartbeat_base + axis.wire.amplifier_node, &Controller::on_amplifier_heartbeat);
    axes_.push_back(std::move(wired));
  }
  bus_ = attach(filters);
  bus_->on_frame([this](const can::Frame& frame, can::Time) { handle(frame); });
  bus_->on_state([this](can::BusState state) { on_bus_state(state); });
}

void Controller::start(bool clear_amplifier_faults) {
  started_ = scheduler_.now();
  sync_sent_ = started_;
  deadline_ = started_ + warm_up;
  next_heartbeat_ = started_ + config_.heartbeat_period;
  bus_->send(can::heartbeat_frame(config_.node, can::NmtState::boot_up));
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

void Controller::tick() {
  close_cycle();
  begin_tracking_ = std::ranges::all_of(axes_, [](const auto& wired) {
    const AxisState state = wired->axis.state();
    return state == AxisState::ready || state == AxisState::tracking;
  });

  const can::Time now = scheduler_.now();
  dt_s_ = can::seconds(now - sync_sent_);
  sync_sent_ = now;
  sync_counter_ = can::next_sync_counter(sync_counter_);
  bus_->send(can::sync_frame(sync_counter_));
  ++counters_.cycles;
  for (const auto& wired : axes_) wired->answered = false;

  if (now >= next_heartbeat_) {
    next_heartbeat_ = now + config_.heartbeat_period;
    bus_->send(can::heartbeat_frame(config_.node, can::NmtState::operational));
    wake_nodes();
  }

  deadline_ += period_;
  while (deadline_ <= now) {  // re-align: a missed deadline is left out, never caught up with
    deadline_ += period_;
    ++counters_.overruns;
  }
  sync_timer_->expire_at(deadline_);
}

/// Axes whose sample has not come are stepped without it.
void Controller::close_cycle() {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (axes_[i]->answered) continue;
    if (axes_[i]->axis.state() > AxisState::waiting) ++counters_.missing_samples;
    step(i, nullptr, scheduler_.now());
  }
}

/// Nodes that wait in pre-operational are started.
void Controller::wake_nodes() {
  const can::Time now = scheduler_.now();
  for (const auto& wired : axes_) {
    if (wired->axis.state() != AxisState::waiting) continue;
    if (wired->sensor_heartbeat.state(now) != can::NmtState::operational)
      bus_->send(can::nmt_frame({can::NmtCommand::start, wired->wire.sensor_node}));
    if (wired->amplifier_heartbeat.state(now) != can::NmtState::operational)
      bus_->send(can::nmt_frame({can::NmtCommand::start, wired->wire.amplifier_node}));
  }
}

void Controller::handle(const can::Frame& frame) {
  if (frame.id >= standard_ids) return;
  const Route& route = routes_[frame.id];
  if (route.handler != nullptr) (this->*route.handler)(route.index, frame);
}

void Controller::on_bus_state(can::BusState state) {
  if (state != can::BusState::bus_off && state != can::BusState::down) return;
  for (const auto& wired : axes_) {
    wired->bus_off_seen |= state == can::BusState::bus_off;
    wired->sensor_heartbeat.forget();
    wired->amplifier_heartbeat.forget();
    wired->decode_sample.restart();
    wired->decode_status.restart();
    wired->status = {};
  }
}

void Controller::on_sample(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  const auto sample = wired.decode_sample(frame);
  if (!sample) return;
  if (sample->sync_counter != sync_counter_ || wired.answered) {
    ++counters_.late_samples;
    return;
  }
  step(index, &*sample, scheduler_.now());
}

void Controller::on_status(std::size_t index, const can::Frame& frame) {
  if (const auto status = axes_[index]->decode_status(frame)) axes_[index]->status = *status;
}

void Controller::on_sensor_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  if (tells_boot_up(frame, wired.sensor_heartbeat)) wired.decode_sample.restart();
}

void Controller::on_amplifier_heartbeat(std::size_t index, const can::Frame& frame) {
  WiredAxis& wired = *axes_[index];
  if (tells_boot_up(frame, wired.amplifier_heartbeat)) wired.decode_status.restart();
}

bool Controller::tells_boot_up(const can::Frame& frame, can::HeartbeatMonitor& monitor) const {
  const auto state = can::parse_heartbeat(frame);
  if (state) monitor.heard(*state, scheduler_.now());
  return state == can::NmtState::boot_up;
}

void Controller::step(std::size_t index, const can::SensorSample* sample, can::Time heard) {
  WiredAxis& wired = *axes_[index];
  wired.answered = true;
  AxisInput input{.time_s = can::seconds(sync_sent_ - started_),
                  .dt_s = dt_s_,
                  .cycle_s = can::seconds(period_),
                  .position_um = std::nullopt,
                  .begin_tracking = begin_tracking_,
                  .health = health(wired)};
  if (sample != nullptr) {
    input.position_um = sample->position_um;
    input.sensor_status_good = sample->status == 0;
  }
  send_command(wired, wired.axis.step(input));
  on_record_({.cycle = counters_.cycles,
              .time_s = input.time_s,
              .axis = index,
              .report = wired.axis.report(),
              .amplifier_output = wired.status.output,
              .turnaround = scheduler_.now() - heard});
}

void Controller::send_command(WiredAxis& wired, const AxisCommand& command) {
  const auto frame = wired.encode_command({.setpoint = command.drive,
                                           .enable = command.enable,
                                           .clear_fault = command.clear_fault,
                                           .sync_counter = sync_counter_});
  if (frame)
    bus_->send(*frame);
  else  // the amplifier's watchdog acts on the silence
    wired.axis.trip(Cause::command_not_sendable, can::seconds(sync_sent_ - started_));
}

NodeHealth Controller::health(WiredAxis& wired) const {
  const can::Time now = scheduler_.now();
  const auto sensor = wired.sensor_heartbeat.state(now);
  const auto amplifier = wired.amplifier_heartbeat.state(now);
  const unsigned boot_ups = wired.sensor_heartbeat.boot_ups() + wired.amplifier_heartbeat.boot_ups();
  const bool restarted = std::exchange(wired.boot_ups_seen, boot_ups) != boot_ups;
  const bool was_off = std::exchange(wired.bus_off_seen, false);
  return {.interface_up = bus_->state() != can::BusState::down,
          .bus_on = bus_->state() != can::BusState::bus_off && !was_off,
          .sensor_alive = sensor.has_value(),
          .sensor_operational = sensor == can::NmtState::operational,
          .amplifier_alive = amplifier.has_value(),
          .amplifier_operational = amplifier == can::NmtState::operational,
          .restarted = restarted,
          .amplifier_ready =
              wired.status.state == can::AmpState::ready || wired.status.state == can::AmpState::enabled,
          .amplifier_enabled = wired.status.state == can::AmpState::enabled,
          .amplifier_fault = wired.status.state == can::AmpState::fault,
          .amplifier_output = wired.status.output};
}

}  // namespace hystcan::controller
