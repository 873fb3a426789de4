// Compares the response times in the rehearsal with the bounds in the plan of the bus. Controller and twin
// run on the simulated bus, with random configurations and every heartbeat switched on.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>

#include "can/dbc/signal_codec.h"
#include "can/protocol/protocol.h"
#include "config/schema/bus_plan.h"
#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/rehearsed.h"
#include "tests/support/shows.h"

namespace hystcan::chain_test {
namespace {

using namespace std::chrono_literals;
using can::Duration;
using can::Time;
using controller::AxisState;

Duration times(double factor, Duration duration) {
  return Duration{std::llround(factor * static_cast<double>(duration.count()))};
}

Duration cycle_of(const config::Config& config) { return controller::cycle_of(config.controller); }

/// Draws identifiers that CANopen does not use: some before SYNC, some among the usual ones, some extended.
class Identifiers {
 public:
  explicit Identifiers(std::mt19937_64& random) : random_(random) {}

  void assign(can::Message& message, bool extended) {
    do {
      message.extended = extended;
      message.id = static_cast<std::uint32_t>(random_() & (extended ? 0x1FFF'FFFFU : 0x7FFU));
    } while (is_reserved(message) || !used_.insert({message.id, extended}).second);
  }

 private:
  static bool is_reserved(const can::Message& message) {
    if (message.extended) return false;
    const std::uint32_t id = message.id;
    return id == 0 || (id >= 0x080 && id < 0x100) || (id >= 0x580 && id < 0x680) || id >= 0x700;
  }

  std::mt19937_64& random_;
  std::set<std::pair<std::uint32_t, bool>> used_;
};

/// The kind of frames in a configuration.
struct Frames {
  bool standard = true;  ///< true: identifiers of docs/protocol/frames.md
  bool extended = false;
  std::uint16_t bytes = 8;
};

/// Returns `count` copies of the first axis of the shipped stage, each with its own messages. They use no
/// feedback, because the effect of the bus on the gains is not tested here.
config::Config axes_like_the_shipped(std::size_t count, const Frames& frames, std::mt19937_64& random) {
  const config::Config shipped = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  config::Config config = shipped;
  config.axes.clear();
  config.database.messages.clear();
  Identifiers identifiers(random);
  for (std::size_t i = 0; i < count; ++i) {
    config::AxisConfig axis = shipped.axes[0];
    axis.wire.name = "axis" + std::to_string(i);
    axis.wire.message_prefix = "A" + std::to_string(i);
    axis.wire.amplifier_node = static_cast<std::uint8_t>(2 * i + 1);
    axis.wire.sensor_node = static_cast<std::uint8_t>(2 * i + 2);
    axis.control.law.structure = controller::Structure::inverse;
    axis.control.following_error.error_um = std::numeric_limits<double>::infinity();
    axis.control.supervision.position_min_um = -1e3;
    axis.control.supervision.position_max_um = 1e3;
    axis.control.supervision.position_jump_um = 0.0;  // the position moves far in a slow cycle
    axis.control.repeat = true;
    for (const char* name : {"XAmpStatus", "XSensorSample", "XAmpCommand", "XControllerStatus"}) {
      can::Message message = *shipped.database.find(name);
      message.name = axis.wire.message_prefix + (name + 1);
      message.length = frames.bytes;
      message.fd = frames.bytes > 8;
      message.id += static_cast<std::uint32_t>(2 * i);
      if (!frames.standard) identifiers.assign(message, frames.extended && random() % 4 != 0);
      config.database.messages.push_back(message);
    }
    config.axes.push_back(axis);
  }
  return config;
}

/// Returns the map of the axis at `place` among those that share `message`. The first axis has the standard
/// signals. Each other axis gets its own signals after the first eight bytes, except for the SYNC counter.
template <class Payload>
can::MessageMap take_place(can::Message& message, std::size_t place) {
  constexpr std::size_t first_bits = 64;
  constexpr std::size_t bits_of_an_axis = 48;
  can::MessageMap map = can::standard_map<Payload>("");
  map.message = message.name;
  if (place == 0) return map;
  for (auto& [role, name] : map.signals) {
    if (role == "sync_counter") continue;
    can::Signal signal = can::find_signal(message, name);
    signal.name = name += std::to_string(place);
    signal.start_bit += static_cast<std::uint32_t>(first_bits + (place - 1) * bits_of_an_axis);
    message.signals.push_back(signal);
  }
  message.length =
      std::max(message.length, static_cast<std::uint16_t>((first_bits + place * bits_of_an_axis) / 8));
  return map;
}

/// Lets sequences of axes share a sensor, and other sequences an amplifier, with or without one common
/// status.
void share_frames(config::Config& config, std::mt19937_64& random) {
  const std::size_t count = config.axes.size();
  const std::size_t of_a_sensor = 1 + random() % count;
  const std::size_t of_an_amplifier = 1 + random() % count;
  const std::size_t of_a_status = random() % 2 == 0 ? of_an_amplifier : 1;
  const auto share = [&]<class Payload>(std::size_t i, std::size_t run) {
    const std::string name(Payload::name);
    const std::string own = config.axes[i].wire.message_prefix + name;
    const std::string first = config.axes[i - i % run].wire.message_prefix + name;
    if (own != first) std::erase_if(config.database.messages, [&](const auto& m) { return m.name == own; });
    return take_place<Payload>(*std::ranges::find(config.database.messages, first, &can::Message::name),
                               i % run);
  };
  for (std::size_t i = 0; i < count; ++i) {
    can::AxisWire& wire = config.axes[i].wire;
    wire.sensor_node = config.axes[i - i % of_a_sensor].wire.sensor_node;
    wire.amplifier_node = config.axes[i - i % of_an_amplifier].wire.amplifier_node;
    wire.frames = can::AxisFrames{.command = share.template operator()<can::AmpCommand>(i, of_an_amplifier),
                                  .status = share.template operator()<can::AmpStatus>(i, of_a_status),
                                  .sample = share.template operator()<can::SensorSample>(i, of_a_sensor)};
  }
}

/// Assigns each node a slot for its heartbeat and statuses.
void give_slots(config::Config& config, std::mt19937_64& random) {
  constexpr std::array<std::uint8_t, 4> rounds{20, 24, 40, 60};  // more than the number of nodes
  config.bus.background_slots = rounds[random() % rounds.size()];
  config.controller.node = static_cast<std::uint8_t>(config.bus.background_slots);
}

/// Sets heartbeats and watchdogs to multiples of the cycle; the phase between heartbeats and cycle varies.
/// Two rounds of slots last at most one heartbeat period.
void set_times(config::Config& config, std::mt19937_64& random) {
  const Duration cycle = cycle_of(config);
  const auto between = [&](double low, double high) {
    return times(std::uniform_real_distribution(low, high)(random), cycle);
  };
  const double round = config.bus.background_slots;
  config.twin.heartbeat_period = between(std::max(4.0, 2.0 * round), 30.0 + 2.0 * round);
  config.controller.heartbeat_period = between(std::max(1.0, 2.0 * round), 30.0 + 2.0 * round);
  config.controller.heartbeat_timeout = 500 * cycle;
  const unsigned status_every = 1 + static_cast<unsigned>(random() % 12);
  for (config::AxisConfig& axis : config.axes) {
    axis.twin.command_timeout = 20 * cycle;
    axis.control.supervision.status_timeout = 2000 * cycle;
    axis.twin.status_every = status_every;
  }
}

/// Sets the fastest of several rates at which, according to the plan, the commands arrive within their cycle.
/// The first rate loads the bus by 30 to 100 %.
std::optional<config::BusPlan> load_the_bus(config::Config& config, std::mt19937_64& random) {
  config.controller.rate_Hz = 10.0;
  const double per_Hz = [&] {
    config::Config quiet = config;
    quiet.twin.heartbeat_period = 10s;
    quiet.controller.heartbeat_period = 10s;
    return config::plan_bus(quiet).load / quiet.controller.rate_Hz;
  }();
  for (double load = std::uniform_real_distribution(0.3, 1.0)(random); load > 0.1; load *= 0.9) {
    config.controller.rate_Hz = load / per_Hz;
    set_times(config, random);
    config::BusPlan plan = config::plan_bus(config);
    if (plan.commands_in_time()) return plan;
  }
  return std::nullopt;
}

void switch_bit_rates(config::Config& config) {
  config.bus.data_bitrate_bit_per_s = 5 * config.bus.bitrate_bit_per_s;
  for (can::Message& message : config.database.messages) message.bit_rate_switch = true;
}

config::Config draw(std::mt19937_64& random) {
  constexpr std::array<std::uint32_t, 5> bitrates{125'000, 250'000, 500'000, 800'000, 1'000'000};
  constexpr std::array<std::uint16_t, 5> lengths{8, 8, 12, 16, 24};
  const Frames frames{.standard = random() % 2 == 0,
                      .extended = random() % 2 == 0,
                      .bytes = lengths[random() % lengths.size()]};
  config::Config config = axes_like_the_shipped(1 + random() % 8, frames, random);
  config.bus.bitrate_bit_per_s = bitrates[random() % bitrates.size()];
  if (frames.bytes > 8) {
    if (random() % 4 != 0) share_frames(config, random);
    if (random() % 2 == 0) switch_bit_rates(config);
  }
  if (random() % 2 == 0) give_slots(config, random);
  config.bus.turnaround = Duration::zero();  // the twin's nodes and the controller answer immediately
  return config;
}

/// Returns the latest arrival of a sample in the plan; shared commands wait for every sample.
Duration latest_sample(const config::BusPlan& plan) {
  Duration latest{};
  for (const config::PlannedFrame& each : plan.frames)
    if (each.frame.name.ends_with("SensorSample"))
      latest = std::max(latest, each.response.value_or(plan.cycle));
  return latest;
}

/// A rehearsal with a listener that compares each frame with its due time.
class Watched {
 public:
  Watched(const config::Config& config, const config::BusPlan& plan)
      : plan_(plan),
        sync_counter_(*config.database.find("A0AmpCommand")->find("SyncCounter")),
        commands_(static_cast<std::size_t>(std::ranges::count_if(
            plan_.frames, [](const auto& each) { return each.frame.name.ends_with("AmpCommand"); }))),
        bit_ns_(1e9 / config.bus.bitrate_bit_per_s),
        beat_(config.twin.heartbeat_period),
        rehearsal_(support::setup_of(config),
                   [this](const controller::CycleRecord& record) { note(record); }),
        listener_(rehearsal_.attach()({})) {
    for (const config::PlannedFrame& each : plan_.frames)
      index_[{each.frame.id, each.frame.extended}] = &each;
    listener_->on_frame([this](const can::Frame& frame, Time end) { receive(frame, end); });
    rehearsal_.start();
  }

  bool tracks() {
    const controller::Controller& loop = rehearsal_.controller();
    for (std::size_t i = 0; i < loop.axis_count(); ++i)
      if (loop.axis(i).state() != AxisState::tracking) return false;
    return true;
  }
  std::string causes() {
    std::string causes;
    const controller::Controller& loop = rehearsal_.controller();
    for (std::size_t i = 0; i < loop.axis_count(); ++i)
      causes.append(to_string(loop.axis(i).state()))
          .append(" ")
          .append(to_string(loop.axis(i).fault().cause))
          .append("; ");
    return causes;
  }
  /// Observes this number of cycles, starting when all axes track.
  void observe(std::uint64_t cycles) {
    const Duration cycle = plan_.cycle;
    for (int i = 0; i < 100 && !tracks(); ++i) rehearsal_.run_for(100 * cycle + 500ms);
    rehearsal_.run_for(10 * cycle);
    watching_ = true;
    late_before_ = counters().late_samples;
    rehearsal_.run_for(static_cast<Duration::rep>(cycles) * cycle);
  }

  controller::CycleCounters counters() { return rehearsal_.controller().counters(); }
  std::uint64_t late_samples() { return counters().late_samples - late_before_; }
  Duration longest(const std::string& name) const {
    const auto found = longest_.find(name);
    return found == longest_.end() ? Duration::zero() : found->second;
  }
  Duration last_command() const { return last_command_; }
  int heartbeats() const { return heartbeats_; }
  int early_heartbeats() const { return early_heartbeats_; }
  int axis_statuses() const { return axis_statuses_; }
  int early_axis_statuses() const { return early_axis_statuses_; }

 private:
  /// Called when a command was queued; its counter names the SYNC that it answers.
  void note(const controller::CycleRecord& record) {
    sync_ = Time{Duration{std::llround(1e9 * record.time_s)}};
    if (record.cycle > 0) sync_of_counter_[1 + (record.cycle - 1) % can::sync_counter_max] = sync_;
  }

  Time sync_answered_by(const can::Frame& command) const {
    return sync_of_counter_.at(static_cast<std::size_t>(sync_counter_.unpack_raw(command.payload())));
  }

  Duration bits_last(unsigned bits) const { return Duration{std::llround(bits * bit_ns_)}; }

  void receive(const can::Frame& frame, Time end) {
    const auto found = index_.find({frame.id, frame.extended});
    if (found == index_.end()) return;
    const std::string& name = found->second->frame.name;
    const Time passed = end + bits_last(can::interframe_bits);
    if (name == "Sync") {
      commands_since_sync_ = 0;
      keep(name, passed - sync_of_this_cycle(end));
    } else if (name == "ControllerHeartbeat") {
      ++heartbeats_;
      if (watching_ && commands_since_sync_ != commands_) ++early_heartbeats_;
    } else if (name.ends_with("ControllerStatus")) {
      ++axis_statuses_;
      if (watching_ && commands_since_sync_ != commands_) ++early_axis_statuses_;
    } else if (name.ends_with("Heartbeat")) {
      if (frame.data[0] != 0) keep(name, passed.time_since_epoch() % beat_);
    } else if (name.ends_with("AmpCommand")) {
      ++commands_since_sync_;
      if (!watching_) return;
      const Time sync = sync_answered_by(frame);
      keep(name, passed - sync);
      last_command_ = std::max(last_command_, passed - bits_last(can::frame_bits(frame).total()) - sync);
    } else {
      keep(name, passed - sync_of_this_cycle(end));  // a sample or a status
    }
  }

  /// Returns the SYNC that began the present cycle: that of the last cycle record, or one a whole number of
  /// cycles later.
  Time sync_of_this_cycle(Time now) const {
    Time sync = sync_;
    while (sync + plan_.cycle < now) sync += plan_.cycle;
    return sync;
  }

  void keep(const std::string& name, Duration response) {
    if (watching_) longest_[name] = std::max(longest_[name], response);
  }

  config::BusPlan plan_;
  can::SignalCodec sync_counter_;  ///< the same codec for every command
  std::size_t commands_;           ///< number of command frames per cycle
  double bit_ns_;
  Duration beat_;
  std::map<std::pair<std::uint32_t, bool>, const config::PlannedFrame*> index_;
  std::map<std::string, Duration> longest_;
  std::array<Time, can::sync_counter_max + 1> sync_of_counter_{};
  Time sync_{};
  std::size_t commands_since_sync_ = 0;
  Duration last_command_{};
  int heartbeats_ = 0;
  int early_heartbeats_ = 0;
  int axis_statuses_ = 0;
  int early_axis_statuses_ = 0;
  bool watching_ = false;
  std::uint64_t late_before_ = 0;
  rehearsal::Rehearsal rehearsal_;
  std::unique_ptr<can::Bus> listener_;
};

TEST(ResponseTimeBound, IsNeverExceededInTheRehearsal) {
  shows("S-094");
  double closest = 0.0;
  double sum = 0.0;
  int runs = 0;
  EXPECT_TRUE(rc::check([&](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    config::Config config = draw(random);
    const auto plan = load_the_bus(config, random);
    RC_PRE(plan.has_value());
    config.controller.command_deadline = latest_sample(*plan);
    Watched watched(config, *plan);
    watched.observe(300);
    if (!watched.tracks()) RC_FAIL("not tracking: " + watched.causes());
    RC_ASSERT(watched.late_samples() == 0U);
    for (const config::PlannedFrame& each : plan->frames) {
      if (each.frame.name.starts_with("Controller") || each.frame.name.ends_with("ControllerStatus"))
        continue;
      const bool waits_for_slot = config.bus.background_slots != 0 && each.frame.name.ends_with("Heartbeat");
      if (!each.response || waits_for_slot) continue;
      Duration bound = *each.response;
      if (each.frame.name.ends_with("Status")) bound += each.frame.jitter;
      if (watched.longest(each.frame.name) > bound)
        RC_FAIL(each.frame.name + ": " + std::to_string(watched.longest(each.frame.name).count()) +
                " ns, bound " + std::to_string(bound.count()));
    }
    if (watched.last_command() > *plan->last_command)
      RC_FAIL("a command begins after " + std::to_string(watched.last_command().count()) + " ns, bound " +
              std::to_string(plan->last_command->count()));
    const double reached = can::seconds(watched.last_command()) / can::seconds(*plan->last_command);
    closest = std::max(closest, reached);
    sum += reached;
    ++runs;
  }));
  EXPECT_GT(closest, 0.7) << "the bound is not far too high";
  RecordProperty("closest", std::to_string(closest));
  RecordProperty("mean", std::to_string(sum / std::max(runs, 1)));
}

TEST(ControllerHeartbeatAndStatus, AreSentAfterTheCommandsOfTheirCycle) {
  shows("S-095");
  std::mt19937_64 random(1);
  config::Config config = axes_like_the_shipped(2, {}, random);
  config.controller.heartbeat_period = 7ms;
  Watched watched(config, config::plan_bus(config));
  watched.observe(500);
  ASSERT_TRUE(watched.tracks());
  EXPECT_GT(watched.heartbeats(), 70);
  EXPECT_EQ(watched.early_heartbeats(), 0);
  EXPECT_GT(watched.axis_statuses(), 140) << "two axes with every heartbeat";
  EXPECT_EQ(watched.early_axis_statuses(), 0);
}

}  // namespace
}  // namespace hystcan::chain_test
