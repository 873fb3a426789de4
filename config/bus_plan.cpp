#include "config/bus_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "can/protocol.h"

namespace hystcan::config {
namespace {

using can::Duration;
using can::PeriodicFrame;

/// Least time between two emergencies of one node: it stays faulted until somebody clears it.
constexpr Duration emergency_interval = std::chrono::seconds(1);

/// How a frame comes to be sent.
enum class Role { sync, sample, command, status, heartbeat };

struct Source {
  PeriodicFrame frame;
  Role role = Role::heartbeat;
  std::size_t axis = 0;
};

Duration cycle_of(const Config& config) {
  return Duration{static_cast<Duration::rep>(std::llround(1e9 / config.controller.rate_Hz))};
}

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
          .deadline = period};
}

std::vector<Source> sources_of(const Config& config) {
  const Duration cycle = cycle_of(config);
  const Duration beat = config.twin.heartbeat_period;
  std::vector<Source> sources;
  sources.push_back({{"Sync", can::sync_id, false, 1, cycle, {}, cycle}, Role::sync, 0});
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    const AxisConfig& axis = config.axes[i];
    const auto add = [&](PeriodicFrame frame, Role role) { sources.push_back({std::move(frame), role, i}); };
    const auto add_message = [&]<class Payload>(Duration period, Role role) {
      if (const auto map = can::message_map<Payload>(axis.wire))
        add(of_message(can::find_message(config.database, *map), period), role);
    };
    add_message.template operator()<can::SensorSample>(cycle, Role::sample);
    add_message.template operator()<can::AmpCommand>(cycle, Role::command);
    add_message.template operator()<can::AmpStatus>(axis.twin.status_every * cycle, Role::status);
    const std::string& prefix = axis.wire.message_prefix;
    add(heartbeat(prefix + "AmpHeartbeat", axis.wire.amplifier_node, beat), Role::heartbeat);
    add(heartbeat(prefix + "SensorHeartbeat", axis.wire.sensor_node, beat), Role::heartbeat);
  }
  sources.push_back(
      {heartbeat("ControllerHeartbeat", config.controller.node, config.controller.heartbeat_period),
       Role::heartbeat, 0});
  std::ranges::sort(sources, {}, [](const Source& s) { return can::arbitration_order(s.frame); });
  return sources;
}

std::vector<PeriodicFrame> emergencies_of(const Config& config) {
  std::vector<PeriodicFrame> frames;
  frames.reserve(2 * config.axes.size());
  for (const AxisConfig& axis : config.axes) {
    for (const auto& [name, node] :
         {std::pair{"AmpEmcy", axis.wire.amplifier_node}, std::pair{"SensorEmcy", axis.wire.sensor_node}}) {
      frames.push_back({axis.wire.message_prefix + name,
                        can::emergency_base + node,
                        false,
                        8,
                        emergency_interval,
                        {},
                        emergency_interval});
    }
  }
  return frames;
}

/// The chain from a SYNC over an axis's sample to its command, or only to the sample.
class Chain {
 public:
  Chain(const Config& config, std::span<const Source> sources, const Source& last)
      : stages_(last.role == Role::command ? 3 : 2),
        bitrate_(config.bus.bitrate_bit_per_s),
        own_(config.bus.turnaround),
        last_(cost(last)),
        bit_((1'000'000'000 + bitrate_ - 1) / bitrate_) {
    for (const Source& source : sources) {
      const bool is_link = source.role == Role::sync || &source == &last ||
                           (source.role == Role::sample && source.axis == last.axis);
      if (is_link) {
        own_ += cost(source);
      } else if (can::arbitration_order(source.frame) < can::arbitration_order(last.frame)) {
        before_.push_back(&source);
      } else {
        after_.push_back(&source);
      }
    }
    std::ranges::sort(after_, std::ranges::greater{}, [this](const Source* s) { return cost(*s); });
  }

  /// w(q) + C, the end of the last link. Empty: beyond `limit`.
  std::optional<Duration> finish(int q, Duration limit) const {
    const Duration own = (q + 1) * own_ - last_;
    Duration begin = own;
    while (begin <= limit) {
      const Duration window = begin + bit_;
      const Duration next = own + blocking(window, std::int64_t{q + 1} * stages_) + interference(window);
      if (next == begin) return begin + last_;
      begin = next;
    }
    return std::nullopt;
  }

 private:
  Duration cost(const Source& source) const { return can::worst_transmission(source.frame, bitrate_); }

  static std::int64_t instances(Duration window, const Source& source) {
    const Duration period = source.frame.period;
    return (window + period - Duration{1}) / period;
  }

  Duration interference(Duration window) const {
    Duration sum{};
    for (const Source* source : before_) sum += instances(window, *source) * cost(*source);
    return sum;
  }

  Duration blocking(Duration window, std::int64_t times) const {
    Duration sum{};
    for (const Source* source : after_) {
      const std::int64_t left_over = source->role == Role::heartbeat ? 1 : 0;  // may be on its way at 0
      const std::int64_t taken = std::min(times, instances(window, *source) + left_over);
      sum += taken * cost(*source);
      times -= taken;
    }
    return sum;
  }

  int stages_;
  std::uint32_t bitrate_;
  Duration own_;   ///< of every link, and the turnaround
  Duration last_;  ///< of the last link
  Duration bit_;
  std::vector<const Source*> before_;
  std::vector<const Source*> after_;
};

/// The worst w(q) + C - q T of each chain, from a SYNC at which none of them had anything left over. Empty:
/// they never catch up.
std::optional<std::vector<Duration>> respond(std::span<const Chain> chains, Duration cycle) {
  constexpr int cycles_max = 100;
  std::vector<Duration> worst(chains.size());
  bool left_over = true;
  for (int q = 0; left_over; ++q) {
    if (q == cycles_max) return std::nullopt;
    left_over = false;
    for (std::size_t i = 0; i < chains.size(); ++i) {
      const auto finished = chains[i].finish(q, (cycles_max + 1) * cycle);
      if (!finished) return std::nullopt;
      worst[i] = std::max(worst[i], *finished - q * cycle);
      left_over = left_over || *finished > (q + 1) * cycle;
    }
  }
  return worst;
}

bool is_end_of_chain(const Source& source) {
  return source.role == Role::sample || source.role == Role::command;
}

/// How much later than its cycle begins a frame may be queued: what the response to others is made of.
void give_jitter(std::vector<Source>& sources, Duration sync_response, Duration turnaround,
                 const std::vector<std::optional<Duration>>& chain_response) {
  for (std::size_t i = 0; i < sources.size(); ++i) {
    Duration& jitter = sources[i].frame.jitter;
    if (sources[i].role == Role::sample || sources[i].role == Role::status)
      jitter = sync_response + turnaround;
    if (sources[i].role == Role::command && chain_response[i]) jitter = *chain_response[i];
  }
}

std::vector<PeriodicFrame> frames_of(const std::vector<Source>& sources) {
  std::vector<PeriodicFrame> frames;
  frames.reserve(sources.size());
  for (const Source& source : sources) frames.push_back(source.frame);
  return frames;
}

PlannedFrame from_queueing(const PeriodicFrame& frame, const can::FrameResponse& answer) {
  PlannedFrame planned{frame, answer.transmission, answer.response, frame.deadline};
  if (planned.response) *planned.response -= frame.jitter;
  return planned;
}

/// For each of `sources` that ends a chain, its response; the others empty.
std::vector<std::optional<Duration>> chain_responses(const Config& config, std::span<const Source> sources) {
  std::vector<Chain> chains;
  chains.reserve(sources.size());
  for (const Source& source : sources)
    if (is_end_of_chain(source)) chains.emplace_back(config, sources, source);
  const auto worst = respond(chains, cycle_of(config));
  std::vector<std::optional<Duration>> responses(sources.size());
  if (!worst) return responses;
  auto next = worst->begin();
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (is_end_of_chain(sources[i])) responses[i] = *next++;
  return responses;
}

}  // namespace

BusPlan plan_bus(const Config& config) {
  const std::uint32_t bitrate = config.bus.bitrate_bit_per_s;
  BusPlan plan;
  plan.cycle = cycle_of(config);
  plan.last_command = Duration::zero();
  std::vector<Source> sources = sources_of(config);
  const auto chains = chain_responses(config, sources);
  const can::Schedule alone = can::analyse(frames_of(sources), bitrate);
  give_jitter(sources, alone.frames.front().response.value_or(plan.cycle), config.bus.turnaround, chains);

  std::vector<PeriodicFrame> all = frames_of(sources);
  const can::Schedule schedule = can::analyse(all, bitrate);
  plan.load = schedule.load;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    PlannedFrame planned = from_queueing(all[i], schedule.frames[i]);
    if (is_end_of_chain(sources[i])) planned.response = chains[i];
    if (sources[i].role == Role::command) {
      planned.deadline = plan.cycle + planned.transmission;
      if (!planned.response) plan.last_command.reset();
      if (plan.last_command)
        plan.last_command = std::max(*plan.last_command, *planned.response - planned.transmission);
    }
    plan.frames.push_back(planned);
  }

  const std::vector<PeriodicFrame> emergencies = emergencies_of(config);
  all.insert(all.end(), emergencies.begin(), emergencies.end());
  const can::Schedule with_emergencies = can::analyse(all, bitrate);
  for (std::size_t i = sources.size(); i < all.size(); ++i)
    plan.emergencies.push_back(from_queueing(all[i], with_emergencies.frames[i]));
  return plan;
}

void check_bus(const Document& document, const Config& config) {
  const BusPlan plan = plan_bus(config);
  if (plan.commands_in_time()) return;
  const auto us = [](Duration duration) { return 1e6 * can::seconds(duration); };
  const std::string found =
      plan.last_command ? fmt::format("the last command may begin only {:.0f} us after its SYNC, at {} bit/s",
                                      us(*plan.last_command), config.bus.bitrate_bit_per_s)
                        : fmt::format("the bus is overloaded: {:.0f} % of {} bit/s", 1e2 * plan.load,
                                      config.bus.bitrate_bit_per_s);
  document.fail_at("controller.rate_Hz",
                   fmt::format("{}, expected at most the cycle, {:.0f} us: lower rate_Hz, raise "
                               "bus.bitrate_bit_per_s or drive fewer axes ({} here)",
                               found, us(plan.cycle), config.axes.size()));
}

}  // namespace hystcan::config
