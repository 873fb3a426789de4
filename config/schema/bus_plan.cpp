#include "config/schema/bus_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "can/protocol/protocol.h"
#include "can/timing/chain.h"
#include "can/timing/schedulability.h"
#include "config/schema/check.h"
#include "config/schema/frames.h"

namespace hystcan::config {
namespace {

using can::Duration;
using can::PeriodicFrame;

/// Assumed minimum time between two emergency frames of a node. A node sends one when it faults, and then
/// remains in fault until the fault is cleared.
constexpr Duration emergency_interval = std::chrono::seconds(1);

/// Assumed minimum time between two live setpoints for one axis, from all senders together. A live setpoint
/// is a frame with which another node sets the position of the axis.
constexpr Duration live_setpoint_interval = std::chrono::milliseconds(10);

Duration cycle_of(const Config& config) { return controller::cycle_of(config.controller); }

PeriodicFrame heartbeat(const std::string& name, unsigned node, Duration period) {
  return {.name = name,
          .id = can::heartbeat_base + node,
          .extended = false,
          .bytes = 1,
          .period = period,
          .jitter = {},
          .deadline = period};
}

PeriodicFrame of_message(const can::Message& message, Duration period) {
  return {.name = message.name,
          .id = message.id,
          .extended = message.extended,
          .bytes = can::wire_length(static_cast<std::uint8_t>(message.length)),
          .period = period,
          .jitter = {},
          .deadline = period,
          .fd = message.fd,
          .bit_rate_switch = message.bit_rate_switch};
}

/// Returns the duration of the shortest scan line of the axis, at most a heartbeat period. Returns a
/// heartbeat period if the axis has no scans.
Duration line_of(const Config& config, const AxisConfig& axis) {
  double line_s = can::seconds(config.controller.heartbeat_period);
  for (const controller::Segment& segment : axis.control.setpoint)
    if (const auto* raster = std::get_if<controller::Raster>(&segment.shape))
      line_s = std::min(line_s, raster->line_s());
  return can::Duration(std::llround(1e9 * line_s));
}

/// Returns the number of the slot in which a node sends heartbeats and statuses; nullopt if there are no
/// slots.
std::optional<unsigned> slot_of(const Config& config, unsigned node) {
  if (config.bus.background_slots == 0) return std::nullopt;
  return node % config.bus.background_slots;
}

/// Returns the duration of a round, the time between two slots of the same node; one cycle if there are no
/// slots.
Duration round_of(const Config& config) {
  return std::max(config.bus.background_slots, 1U) * cycle_of(config);
}

/// Returns the smallest number of rounds that together take at least `time`.
std::int64_t rounds_up(Duration time, Duration round) { return (time + round - Duration{1}) / round; }

/// Adds the controller's axis statuses and scan markers (a marker is sent when a line of a raster begins) if
/// the database has messages for them. In the cycle in which the heartbeat is due, the statuses of all axes
/// become due together. They wait for each other: the controller sends at most one marker or status per
/// cycle, after its commands, or in its slot if the bus has slots.
void add_own_frames(std::vector<can::ChainSource>& sources, const Config& config) {
  const Duration cycle = cycle_of(config);
  const std::size_t first = sources.size();
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    if (const auto map = can::message_map_in<can::ControllerStatus>(config.database, config.axes[i].wire))
      sources.push_back({of_message(can::find_message(config.database, *map), cycle),
                         can::ChainRole::controller_status,
                         {i}});
  const std::size_t statuses_end = sources.size();
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    if (config.axes[i].scan_marker)
      if (const auto map = can::message_map_in<can::ScanMarker>(config.database, config.axes[i].wire))
        sources.push_back(
            {of_message(can::find_message(config.database, *map), line_of(config, config.axes[i])),
             can::ChainRole::controller_status,
             {i}});
  const auto in_turn = static_cast<Duration::rep>(sources.size() - first);
  const Duration round =
      slot_of(config, config.controller.node) ? (in_turn + 1) * round_of(config) : in_turn * cycle;
  for (std::size_t i = first; i < sources.size(); ++i) {
    can::PeriodicFrame& frame = sources[i].frame;
    sources[i].slot = slot_of(config, config.controller.node);
    if (i < statuses_end) frame.period = std::max(config.controller.heartbeat_period, round);
    frame.deadline = frame.period;
    frame.jitter = round;
  }
}

bool has_identifier(const PeriodicFrame& frame, const PeriodicFrame& of) {
  return frame.id == of.id && frame.extended == of.extended;
}

/// Adds a frame of an axis. If another axis already added the same frame (axes can share a message or a
/// node's heartbeat), adds the axis to that frame.
void add_for_axis(std::vector<can::ChainSource>& sources, PeriodicFrame frame, can::ChainRole role,
                  std::size_t axis, std::optional<unsigned> slot = {}) {
  const auto shared = std::ranges::find_if(sources, [&](const can::ChainSource& source) {
    return source.role == role && has_identifier(source.frame, frame);
  });
  if (shared == sources.end()) {
    sources.push_back({std::move(frame), role, {axis}, slot});
    return;
  }
  shared->axes.push_back(axis);
  shared->frame.period = std::min(shared->frame.period, frame.period);
  shared->frame.deadline = shared->frame.period;
}

/// The shorter and the longer value of status_every, the period of AmpStatus in cycles. The twin and the
/// analogue node each have a value, and either of them may be the amplifier on the bus.
struct StatusPeriods {
  unsigned shortest, longest;
};
StatusPeriods statuses_of(const AxisConfig& axis) {
  const unsigned twin = axis.twin.status_every;
  const unsigned node = axis.analogue ? axis.analogue->amplifier.status_every : twin;
  return {std::min(twin, node), std::max(twin, node)};
}

std::vector<can::ChainSource> sources_of(const Config& config) {
  const Duration cycle = cycle_of(config);
  const Duration beat = config.twin.heartbeat_period;
  std::vector<can::ChainSource> sources;
  sources.push_back({{"Sync", can::sync_id, false, 1, cycle, {}, cycle}, can::ChainRole::sync, {}});
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const AxisConfig& axis = config.axes[i];
    const auto add_heartbeat = [&](const char* name, unsigned node) {
      add_for_axis(sources, heartbeat(axis.wire.message_prefix + name, node, beat), can::ChainRole::heartbeat,
                   i, slot_of(config, node));
    };
    const auto add_message = [&]<class Payload>(Duration period, can::ChainRole role,
                                                std::optional<unsigned> slot = {}) {
      if (const auto map = can::message_map_in<Payload>(config.database, axis.wire))
        add_for_axis(sources, of_message(can::find_message(config.database, *map), period), role, i, slot);
    };
    add_message.template operator()<can::SensorSample>(cycle, can::ChainRole::sample);
    add_message.template operator()<can::AmpCommand>(cycle, can::ChainRole::command);
    add_message.template operator()<can::AmpStatus>(
        rounds_up(statuses_of(axis).shortest * cycle, round_of(config)) * round_of(config),
        can::ChainRole::status, slot_of(config, axis.wire.amplifier_node));
    if (axis.live_setpoint)
      add_message.template operator()<can::Setpoint>(live_setpoint_interval, can::ChainRole::live_setpoint);
    add_heartbeat("AmpHeartbeat", axis.wire.amplifier_node);
    add_heartbeat("SensorHeartbeat", axis.wire.sensor_node);
  }
  add_own_frames(sources, config);
  PeriodicFrame own = heartbeat("ControllerHeartbeat", config.controller.node,
                                std::max(config.controller.heartbeat_period, cycle));
  // A heartbeat becomes due at a SYNC. It then waits for the commands of the cycle, or for the controller's
  // slot: at most one round.
  own.jitter = round_of(config);
  sources.push_back({own, can::ChainRole::controller_heartbeat, {}, slot_of(config, config.controller.node)});
  std::ranges::sort(sources, {}, [](const can::ChainSource& s) {
    return can::arbitration_key(s.frame.id, s.frame.extended);
  });
  return sources;
}

std::vector<PeriodicFrame> emergencies_of(const Config& config) {
  std::vector<PeriodicFrame> frames;
  frames.reserve(2 * config.axes.size());
  for (const AxisConfig& axis : config.axes) {
    for (const auto& [name, node] :
         {std::pair{"AmpEmcy", axis.wire.amplifier_node}, std::pair{"SensorEmcy", axis.wire.sensor_node}}) {
      PeriodicFrame frame{.name = axis.wire.message_prefix + name,
                          .id = can::emergency_base + node,
                          .period = emergency_interval,
                          .jitter = {},
                          .deadline = emergency_interval};
      if (std::ranges::none_of(frames, [&](const PeriodicFrame& f) { return has_identifier(f, frame); }))
        frames.push_back(std::move(frame));
    }
  }
  return frames;
}

std::vector<PeriodicFrame> frames_of(const std::vector<can::ChainSource>& sources) {
  std::vector<PeriodicFrame> frames;
  frames.reserve(sources.size());
  for (const can::ChainSource& source : sources) frames.push_back(source.frame);
  return frames;
}

PlannedFrame planned(const can::ChainSource& source, const can::BitRates& rates) {
  PlannedFrame planned{source.frame, can::worst_transmission(source.frame, rates), source.response,
                       source.frame.deadline};
  if (!is_link(source.role) && planned.response) *planned.response -= source.frame.jitter;
  return planned;
}

/// Checks the key command_deadline_us if axes share a command frame: the controller sends the frame at the
/// deadline at the latest. Throws Error if samples of these axes can arrive after the deadline.
void check_command_deadline(const Checked& checked, const BusPlan& plan) {
  const Config& config = checked.config;
  const Duration deadline = controller::command_deadline_of(config.controller);
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const std::size_t first = first_sharing<can::AmpCommand>(config, i);
    if (first == i) continue;
    for (const std::size_t axis : {first, i}) {
      const std::string message = can::message_map<can::SensorSample>(config.axes[axis].wire)->message;
      const auto sample = std::ranges::find(plan.frames, message,
                                            [](const PlannedFrame& planned) { return planned.frame.name; });
      if (sample->response && *sample->response <= deadline) continue;
      checked.fail(
          config.controller.command_deadline,
          "the effective command_deadline_us is {:.0f}, expected at least {:.0f}: by then all samples in "
          "message {} have arrived",
          1e6 * can::seconds(deadline), 1e6 * can::seconds(sample->response.value_or(plan.cycle)), message);
    }
  }
}

/// Returns all node ids on the bus with a description for the user, such as "the sensor of axis x".
std::map<unsigned, std::string> nodes_of(const Config& config) {
  std::map<unsigned, std::string> nodes{{config.controller.node, "the controller"}};
  for (const AxisConfig& axis : config.axes) {
    nodes.emplace(axis.wire.amplifier_node, fmt::format("the amplifier of axis {}", axis.wire.name));
    nodes.emplace(axis.wire.sensor_node, fmt::format("the sensor of axis {}", axis.wire.name));
  }
  return nodes;
}

void check_slots(const Checked& checked) {
  const Config& config = checked.config;
  const unsigned& slots = config.bus.background_slots;
  if (slots == 0) return;
  const auto fail = [&](const std::string& text) { checked.fail(slots, "{}", text); };
  if (can::sync_counter_max % slots != 0)
    fail(fmt::format("background_slots is {}, expected a divisor of {}, the highest SYNC counter", slots,
                     can::sync_counter_max));
  std::map<unsigned, std::pair<unsigned, std::string>> owners;  // for each slot, its node and the node's name
  for (const auto& [node, name] : nodes_of(config)) {
    const unsigned slot = *slot_of(config, node);
    const auto [other, is_new] = owners.try_emplace(slot, node, name);
    if (!is_new)
      fail(fmt::format(
          "nodes {} ({}) and {} ({}) have the same slot, {} of {}, expected node ids with different "
          "remainders after division by background_slots",
          other->second.first, other->second.second, node, name, slot, slots));
  }
  const Duration longest = std::min(config.twin.heartbeat_period, config.controller.heartbeat_period);
  if (2 * round_of(config) > longest)
    fail(fmt::format(
        "two rounds of {} background slots take {:.3g} ms, expected at most {:g}, the shorter heartbeat_ms "
        "of [controller] and [twin]: between two heartbeats, a node needs another slot for its status",
        slots, 2e3 * can::seconds(round_of(config)), 1e3 * can::seconds(longest)));
  const Duration gap =
      round_of(config) + std::max(config.twin.heartbeat_period, config.controller.heartbeat_period);
  if (2 * gap > config.controller.heartbeat_timeout)
    fail(fmt::format(
        "with {} background slots two heartbeats may be {:.4g} ms apart, expected at most {:g}, half of "
        "heartbeat_timeout_ms",
        slots, 1e3 * can::seconds(gap), 0.5e3 * can::seconds(config.controller.heartbeat_timeout)));
  for (const AxisConfig& axis : config.axes)
    if (axis.scan_marker && 2 * round_of(config) > line_of(config, axis))
      fail(fmt::format(
          "two rounds of {} background slots take {:.3g} ms, expected at most {:g}, the duration of a line "
          "of axis {}: the controller sends a scan marker only in its slot, and every second slot may have a "
          "heartbeat instead",
          slots, 2e3 * can::seconds(round_of(config)), 1e3 * can::seconds(line_of(config, axis)),
          axis.wire.name));
}

}  // namespace

can::Duration longest_status_period(const Config& config, const AxisConfig& axis) {
  const Duration least = statuses_of(axis).longest * cycle_of(config);
  if (config.bus.background_slots == 0) return least;
  std::set<std::string> messages;
  for (const AxisConfig& other : config.axes)
    if (const auto map = can::message_map_in<can::AmpStatus>(config.database, other.wire);
        map && other.wire.amplifier_node == axis.wire.amplifier_node)
      messages.insert(map->message);
  const auto needed = static_cast<std::int64_t>(messages.size());
  const Duration round = round_of(config);
  std::int64_t rounds = 1;
  while (rounds * round < least || rounds - rounds_up(rounds * round, config.twin.heartbeat_period) < needed)
    ++rounds;
  return rounds * round;
}

BusPlan plan_bus(const Config& config) {
  const can::BitRates rates = config.bus.rates();
  BusPlan plan;
  plan.cycle = cycle_of(config);
  plan.last_command = Duration::zero();
  std::vector<can::ChainSource> sources = sources_of(config);
  can::respond(sources, {.rates = rates,
                         .cycle = plan.cycle,
                         .turnaround = config.bus.turnaround,
                         .slots = config.bus.background_slots});

  plan.frames.reserve(sources.size());
  for (const can::ChainSource& source : sources) {
    plan.frames.push_back(planned(source, rates));
    PlannedFrame& frame = plan.frames.back();
    if (source.role != can::ChainRole::command) continue;
    frame.deadline = plan.cycle + frame.transmission;
    if (!frame.response) plan.last_command.reset();
    if (plan.last_command)
      plan.last_command = std::max(*plan.last_command, *frame.response - frame.transmission);
  }

  std::vector<PeriodicFrame> all = frames_of(sources);
  plan.load = can::analyse(all, rates).load;
  const std::vector<PeriodicFrame> emergencies = emergencies_of(config);
  all.insert(all.end(), emergencies.begin(), emergencies.end());
  plan.emergencies.reserve(emergencies.size());
  const can::Schedule with_emergencies = can::analyse(all, rates);
  for (std::size_t i = sources.size(); i < all.size(); ++i) {
    const can::FrameResponse& answer = with_emergencies.frames[i];
    plan.emergencies.push_back({all[i], answer.transmission, answer.response, all[i].deadline});
  }
  return plan;
}

double fastest_rate_Hz(Config config) {
  const auto is_in_time = [&](double rate_Hz) {
    config.controller.rate_Hz = rate_Hz;
    return plan_bus(config).commands_in_time();
  };
  double fits = 1.0;
  double fails = config.controller.rate_Hz;
  if (is_in_time(fails)) return fails;
  if (!is_in_time(fits)) return 0.0;
  while (fails > 1.0001 * fits) {
    const double middle = std::sqrt(fits * fails);
    (is_in_time(middle) ? fits : fails) = middle;
  }
  const double step = fits < 100.0 ? 1.0 : 10.0;
  const double rounded = std::floor(fits / step) * step;
  return is_in_time(rounded) ? rounded : fits;
}

void check_bus(const Checked& checked) {
  const Config& config = checked.config;
  check_slots(checked);
  const BusPlan plan = plan_bus(config);
  if (plan.commands_in_time()) return check_command_deadline(checked, plan);
  const auto us = [](Duration duration) { return 1e6 * can::seconds(duration); };
  const std::string found =
      plan.last_command
          ? fmt::format("the last command may start {:.0f} us after its SYNC, at {} bit/s",
                        us(*plan.last_command), config.bus.bitrate_bit_per_s)
          : fmt::format("the bus is loaded to {:.0f} % of {} bit/s, and commands arrive too late",
                        1e2 * plan.load, config.bus.bitrate_bit_per_s);
  const double fastest_Hz = fastest_rate_Hz(config);
  const std::string cure =
      fastest_Hz > 0.0 ? fmt::format("lower rate_Hz ({:g} Hz fits)", fastest_Hz) : "lower rate_Hz";
  const std::string slow_phase = path_of(
      config, fd_messages(config).empty() ? config.bus.bitrate_bit_per_s : config.bus.data_bitrate_bit_per_s);
  checked.fail(config.controller.rate_Hz,
               "{}, expected within the cycle of {:.0f} us: {}, raise {}, or drive fewer axes than now ({})",
               found, us(plan.cycle), cure, slow_phase, config.axes.size());
}

}  // namespace hystcan::config
