#include "tests/support/fault_rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace hystcan::support {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;

// Axis x of config/piezo.toml.
constexpr std::uint8_t amplifier_node = 1;
constexpr std::uint8_t sensor_node = 2;
constexpr std::uint32_t command_id = can::receive_pdo_base + amplifier_node;
constexpr std::uint32_t sample_id = can::transmit_pdo_base + sensor_node;

// Byte positions of config/hystcan.dbc.
constexpr std::size_t counter_byte = 6;
constexpr std::size_t crc_byte = 7;

/// Maximum time on the wire of a frame that is destroyed at its first bit, at 1 Mbit/s.
constexpr auto destroyed_frame = std::chrono::microseconds(1 + can::error_flags_max_bits +
                                                           can::error_delimiter_bits + can::interframe_bits);

std::uint8_t crc_of(const can::Frame& frame) {
  std::array<std::uint8_t, 9> covered{};
  covered[0] = static_cast<std::uint8_t>(frame.id & 0xFFU);
  covered[1] = static_cast<std::uint8_t>(frame.id >> 8U);
  std::copy_n(frame.data.begin(), crc_byte, covered.begin() + 2);
  return can::crc8_j1850(covered);
}

/// Changes a frame. A valid CRC stays valid, and a wrong one stays wrong.
template <class Change>
void change_protected(can::Frame& frame, Change change) {
  const auto wrong_bits = static_cast<std::uint8_t>(frame.data[crc_byte] ^ crc_of(frame));
  change(frame);
  frame.data[crc_byte] = static_cast<std::uint8_t>(crc_of(frame) ^ wrong_bits);
}

std::int32_t value_of(const can::Frame& frame) {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < 4; ++i) bits |= std::uint32_t{frame.data[i]} << 8U * i;
  return static_cast<std::int32_t>(bits);
}

void put_value(can::Frame& frame, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < 4; ++i) frame.data[i] = static_cast<std::uint8_t>(bits >> 8U * i);
}

std::int32_t micrometres(double um) { return static_cast<std::int32_t>(std::lround(1e6 * um)); }

/// Returns a second sample for the same SYNC, which the controller accepts in addition to the sensor's own.
can::Frame forged(can::Frame sample) {
  change_protected(sample, [](can::Frame& frame) {
    frame.data[counter_byte] = static_cast<std::uint8_t>((frame.data[counter_byte] + 8U) & 0x0FU);
    put_value(frame, value_of(frame) + micrometres(1.0));
  });
  return sample;
}

/// Returns the faults of the twin that cause this trouble; empty if the twin has no such fault.
std::vector<twin::FaultSpec> twin_faults(Trouble trouble) {
  using twin::Fault;
  using twin::Node;
  const auto of = [](Node node, Fault kind, double value = 0.0) {
    return twin::FaultSpec{.kind = kind, .axis = "x", .node = node, .value = value};
  };
  switch (trouble) {
    case Trouble::sample_lost:
      return {of(Node::sensor, Fault::no_reply)};
    case Trouble::sample_late:
      return {of(Node::sensor, Fault::late, 1.0)};
    case Trouble::sample_frozen:
      return {of(Node::sensor, Fault::frozen_value)};
    case Trouble::counter_frozen:
      return {of(Node::sensor, Fault::frozen_counter)};
    case Trouble::sample_beyond:
      return {of(Node::sensor, Fault::out_of_range, 60.0)};
    case Trouble::sample_bad:
      return {of(Node::sensor, Fault::sensor_bad_status)};
    case Trouble::sample_damaged:
      return {of(Node::sensor, Fault::wrong_crc)};
    case Trouble::sensor_emergency:
      return {of(Node::sensor, Fault::emergency, 0x5000)};
    case Trouble::sensor_unheard:
      return {of(Node::sensor, Fault::no_heartbeat)};
    case Trouble::amplifier_unheard:
      return {of(Node::amplifier, Fault::no_heartbeat), of(Node::amplifier, Fault::no_reply)};
    case Trouble::amplifier_trips:
      return {of(Node::amplifier, Fault::amplifier_trip)};
    case Trouble::commands_lost:
      return {of(Node::amplifier, Fault::watchdog_trip)};
    case Trouble::enable_lost:
      return {of(Node::amplifier, Fault::relay_opens)};
    case Trouble::statuses_lost:
      return {of(Node::amplifier, Fault::no_reply)};
    default:
      return {};
  }
}

void make_quick(controller::AxisConfig& control) {
  // A slow loop: a faster one would follow a drifting sensor until the drive reaches its limit.
  control.law.pi = {.kp = 0.05, .ki_per_s = 120.0};
  control.setpoint = {
      {.shape = controller::Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 2.0, .cycles = 1000.0},
       .transition_s = 0.1}};
  control.repeat = true;
  control.wipe_slew_per_s = 2000.0;
  control.wipe_dwell_s = 0.01;
  control.supervision.position_jump_um = 1.5;
  control.supervision.saturated_s = 0.05;
  control.supervision.bus_passive_s = 0.05;
  control.supervision.status_timeout = milliseconds(400);
}

}  // namespace

WireMonitor::Config monitor_config(const config::Config& config, std::size_t index) {
  const config::AxisConfig& axis = config.axes[index];
  const twin::Amplifier::Config& amplifier = axis.twin.plant.amplifier;
  const double range = amplifier.drive_max - amplifier.drive_min;
  constexpr double tolerance = 1e-3;
  const double settle_s = range / amplifier.slew_per_s +
                          std::log(range / tolerance) / (2.0 * std::numbers::pi * amplifier.bandwidth_Hz);
  const double cycle_s = 1.0 / config.controller.rate_Hz;
  const auto time = [](double s) { return can::Duration(std::llround(1e9 * s)); };
  constexpr double frame_s = 150e-6;  // eight bytes and their stuff bits at 1 Mbit/s
  return {.wire = axis.wire,
          .gate = axis.control.gate,
          .output_min = amplifier.drive_min,
          .output_max = amplifier.drive_max,
          .tolerance = tolerance,
          .settle = time(settle_s),
          .off_within = axis.twin.command_timeout + time(cycle_s + frame_s),
          .grace = time(cycle_s + 2 * frame_s),
          .jitter = time(2 * frame_s)};
}

std::string_view to_string(Trouble trouble) {
  static constexpr std::array<std::string_view, trouble_count> names{
      "sample_lost",       "sample_late",    "sample_frozen",     "counter_frozen",
      "sample_jumped",     "sample_beyond",  "sample_bad",        "sample_damaged",
      "sensor_emergency",  "sensor_unheard", "amplifier_unheard", "sensor_stopped",
      "amplifier_stopped", "sensor_leaves",  "sensor_reset",      "amplifier_reset",
      "amplifier_trips",   "commands_lost",  "enable_lost",       "bus_passive",
      "bus_off",           "interface_down", "position_drifts",   "load_pulls",
      "sync_late",         "stall",          "foreign_sync",      "foreign_heartbeat",
      "foreign_write",     "forged_sample",  "statuses_lost",     "law_not_finite"};
  return names[static_cast<std::size_t>(trouble)];
}

bool is_between_steps(controller::Cause cause) {
  using enum controller::Cause;
  return cause == another_controller || cause == cycle_overrun || cause == command_not_sendable ||
         cause == foreign_access || cause == sample_doubled;
}

namespace {

config::Config quick_piezo(const std::vector<config::Setting>& settings) {
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml", settings);
  config.axes.resize(1);
  config.controller.lateness_trip = std::chrono::microseconds(400);
  make_quick(config.axes[0].control);
  return config;
}

}  // namespace

config::Config one_axis() { return quick_piezo({}); }

config::Config one_axis_on_a_card() {
  const auto of_axis = [](const std::string& key, const std::string& value) {
    return config::Setting{"axis[0].analogue." + key, value};
  };
  return quick_piezo({of_axis("device", "\"simulated\""), of_axis("volts_per_drive", "0.09"),
                      of_axis("position_um_per_V", "3.3"), of_axis("drive_output.channel", "0"),
                      of_axis("drive_output.range", "\"0..10 V\""), of_axis("position_input.channel", "0"),
                      of_axis("output_input.channel", "1"), of_axis("output_input.range", "\"0..10 V\""),
                      of_axis("interlock_line.line", "0")});
}

config::Config two_axes_in_a_frame() {
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/fd_stage.toml");
  for (config::AxisConfig& axis : config.axes) make_quick(axis.control);
  return config;
}

FaultRig::FaultRig(const config::Config& config)
    : config_(config),
      monitor_bus_(bus_.attach()),
      tester_(bus_.attach()),
      was_faulted_(config_.axes.size()) {
  monitors_.reserve(config_.axes.size());
  for (std::size_t i = 0; i < config_.axes.size(); ++i)
    monitors_.emplace_back(monitor_config(config_, i), config_.database);
  monitor_bus_->on_frame([this](const can::Frame& frame, can::Time when) {
    for (WireMonitor& monitor : monitors_) monitor.receive(frame, when);
  });
  const auto attach = [this](std::span<const can::Filter> filters) { return attach_node(filters); };
  if (config_.axes[0].analogue)
    card_nodes_ = std::make_unique<CardNodes>(config_, clock_, attach);
  else
    twin_ = std::make_unique<twin::Twin>(twin_config(config_), config_.database, clock_, attach);
  controller_ = std::make_unique<controller::Controller>(
      controller_config(config_), config_.database, sleeper_,
      [this](std::span<const can::Filter>) {
        auto node = bus_.attach();
        controller_node_ = node.get();
        auto connection = std::make_unique<HookedConnection>(std::move(node));
        controller_connection_ = connection.get();
        return connection;
      },
      [this](const controller::CycleRecord&) { note_fault(clock_.now()); });
  controller_connection_->after_frame = [this](can::Time received) { note_fault(received); };
  controller_->listen_to(requests_);
}

void FaultRig::start() {
  twin_ ? twin_->start() : card_nodes_->start();
  controller_->start();
}

twin::FaultTarget FaultRig::stage() {
  return twin_ ? twin_->axes()[0]->fault_target() : card_nodes_->fault_target();
}

std::unique_ptr<can::Bus> FaultRig::listen(std::function<void(const can::Frame&)> handler) {
  std::unique_ptr<can::Bus> node = bus_.attach();
  node->on_frame([handle = std::move(handler)](const can::Frame& frame, can::Time) { handle(frame); });
  return node;
}

/// Recognises the amplifier's node by its filters: only this node has a filter for commands (twin/twin.cpp).
std::unique_ptr<can::Bus> FaultRig::attach_node(std::span<const can::Filter> filters) {
  auto node =
      bus_.attach(config_.axes[0].analogue ? can::TransmitOrder::as_sent : can::TransmitOrder::by_priority);
  const bool is_amplifier = std::ranges::any_of(filters, [](const auto& f) { return f.id == command_id; });
  if (is_amplifier) return node;
  return std::make_unique<HookedConnection>(std::move(node),
                                            [this](can::Frame& frame) { return sensor_sends(frame); });
}

void FaultRig::note_fault(can::Time when) {
  for (std::size_t i = 0; i < monitors_.size(); ++i) {
    const bool is_faulted = axis(i).state() == AxisState::faulted;
    if (is_faulted && !was_faulted_[i]) {
      monitors_[i].report_fault(when);
      if (i == 0) ++faults_, decided_at_ = when;
    }
    was_faulted_[i] = is_faulted;
  }
}

void FaultRig::run_for(can::Duration time) { clock_.run_until(clock_.now() + time); }

bool FaultRig::reaches(AxisState state, can::Duration limit) {
  const can::Time end = clock_.now() + limit;
  while (axis().state() != state && clock_.now() < end) run_for(milliseconds(1));
  return axis().state() == state;
}

bool FaultRig::sensor_sends(can::Frame& frame) {
  if (frame.id == can::heartbeat_base + sensor_node && is_on(Trouble::sensor_leaves))
    frame = can::heartbeat_frame(sensor_node, can::NmtState::pre_operational);
  if (frame.id != sample_id) return true;
  displace(frame);
  if (is_on(Trouble::forged_sample)) send(forged(frame));
  return true;
}

/// Drift and jump have the same direction, so that they do not cancel each other. The load pulls slowly: the
/// drive compensates it until it saturates.
void FaultRig::displace(can::Frame& sample) {
  if (is_on(Trouble::position_drifts)) offset_um_ = std::min(offset_um_ + 1.0, 7.5);
  if (is_on(Trouble::load_pulls)) offset_um_ = std::max(offset_um_ - 0.05, -7.0);
  const double jump_um = is_on(Trouble::sample_jumped) ? 8.0 : 0.0;
  if (offset_um_ + jump_um == 0.0) return;
  change_protected(sample, [&](can::Frame& frame) {
    put_value(frame, value_of(frame) + micrometres(offset_um_ + jump_um));
  });
}

void FaultRig::begin(Trouble trouble) {
  on_[static_cast<std::size_t>(trouble)] = true;
  for (const twin::FaultSpec& fault : twin_faults(trouble)) stage_faults().inject(fault);
  switch (trouble) {
    case Trouble::sensor_stopped:
      return send(can::nmt_frame({can::NmtCommand::stop, sensor_node}));
    case Trouble::amplifier_stopped:
      return send(can::nmt_frame({can::NmtCommand::stop, amplifier_node}));
    case Trouble::sensor_reset:
      return interrupt_supply(twin::Node::sensor);
    case Trouble::amplifier_reset:
      return interrupt_supply(twin::Node::amplifier);
    case Trouble::foreign_write:
      return send(
          can::sdo_request(amplifier_node, {.service = can::SdoService::write, .object = {.index = 0x2000}}));
    case Trouble::foreign_sync:
      return send(can::sync_frame(can::sync_counter_max));
    case Trouble::foreign_heartbeat:
      return send(can::heartbeat_frame(config_.controller.node, can::NmtState::operational));
    case Trouble::bus_passive:
      return controller_connection_->pretend(can::BusState::passive);
    case Trouble::interface_down:
      return controller_connection_->pretend(can::BusState::down);
    case Trouble::bus_off:
      return controller_node_->set_faults({.transmit_bit_error = 1.0});
    case Trouble::sync_late:
      sleeper_.by = std::chrono::microseconds(500);
      return;
    case Trouble::stall:
      sleeper_.by = milliseconds(20);
      run_for(milliseconds(1));
      sleeper_.by = {};
      return;
    case Trouble::law_not_finite: {
      controller::AxisConfig broken = axis().config();
      broken.law.pi.kp = std::numeric_limits<double>::quiet_NaN();
      retune(broken);
      return;
    }
    default:
      return;
  }
}

void FaultRig::interrupt_supply(twin::Node node) {
  const twin::FaultSpec reboot{.kind = twin::Fault::node_reboot, .axis = "x", .node = node};
  stage_faults().inject(reboot);
  stage_faults().remove(reboot.kind);
}

void FaultRig::end(Trouble trouble) {
  on_[static_cast<std::size_t>(trouble)] = false;
  end_twin_faults(trouble);
  switch (trouble) {
    case Trouble::bus_passive:
    case Trouble::interface_down:
      if (!is_on(Trouble::bus_passive) && !is_on(Trouble::interface_down))
        controller_connection_->pretend({});
      return;
    case Trouble::bus_off:
      controller_node_->set_faults({});
      run_for(destroyed_frame);  // the last frame is on the wire, and the node may switch off at its end
      return controller_node_->restart();
    case Trouble::sync_late:
      sleeper_.by = {};
      return;
    case Trouble::position_drifts:
    case Trouble::load_pulls:
      offset_um_ = 0.0;
      return;
    case Trouble::law_not_finite:
      retune(config_.axes[0].control);
      return;
    default:
      return;
  }
}

/// The twin ends a kind of fault at both nodes, so this function restarts each other trouble that is the same
/// kind of fault.
void FaultRig::end_twin_faults(Trouble trouble) {
  for (const twin::FaultSpec& over : twin_faults(trouble)) {
    stage_faults().remove(over.kind);
    for (std::size_t i = 0; i < trouble_count; ++i)
      for (const twin::FaultSpec& other : twin_faults(static_cast<Trouble>(i)))
        if (on_[i] && other.kind == over.kind) stage_faults().inject(other);
  }
}

std::string_view FaultRig::ask(controller::Request::Kind kind, std::size_t index) {
  auto request = std::make_unique<controller::Request>();
  request->kind = kind;
  request->axis = index;
  const bool clears = kind == controller::Request::Kind::clear && axis(index).state() == AxisState::faulted;
  const std::string_view refused = run_until_answered(std::move(request));
  if (clears && refused.empty()) monitors_[index].report_clear();
  return refused;
}

std::string_view FaultRig::retune(const controller::AxisConfig& next) {
  auto request = std::make_unique<controller::Request>();
  request->kind = controller::Request::Kind::retune;
  request->tuning = std::make_unique<controller::AxisTuning>(next, false);
  return run_until_answered(std::move(request));
}

std::string_view FaultRig::run_until_answered(std::unique_ptr<controller::Request> request) {
  if (!requests_.ask(std::move(request))) return "too many requests are unanswered";
  for (int cycle = 0; cycle < 100; ++cycle) {
    run_for(milliseconds(1));
    if (const auto answer = requests_.take_answer())
      return answer->refusal ? to_string(*answer->refusal) : "";
  }
  return "no answer";
}

}  // namespace hystcan::support
