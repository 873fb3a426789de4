// Random traffic through the nodes of node/firmware and through those of the twin, on two simulated buses.
// Both send the same frames at the same times.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "can/sim/sim_bus.h"
#include "config/schema/config.h"
#include "tests/node/firmware_nodes.h"
#include "tests/node/traffic.h"
#include "tests/support/long_run.h"
#include "tests/twin/shared_bench.h"
#include "twin/twin.h"

namespace hystcan::firmware::same_frames_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// No frame arrives between two whole microseconds: otherwise a timer could expire at the time of a frame, in
/// the order of the scheduler.
constexpr nanoseconds heartbeat{20'000'057}, timeout{8'000'313}, relay{5'000'171}, slow_relay{25'000'171};

struct Received {
  can::Time time;
  can::Frame frame;
  friend bool operator==(const Received&, const Received&) = default;
};

std::string text_of(const Received& received) {
  return fmt::format("{:.9f} {:X}#{:02X}", can::seconds(received.time.time_since_epoch()), received.frame.id,
                     fmt::join(received.frame.payload(), ""));
}

/// A bus with a tester, and a listener that stores the received frames.
struct Side {
  Side(can::VirtualClock& clock, can::BitRates rates) : bus(clock, rates) {}
  void listen() {
    tester = bus.attach();
    listener = bus.attach();
    listener->on_frame([this](const can::Frame& frame, can::Time time) { frames.push_back({time, frame}); });
  }
  can::Attach attach() {
    return [this](std::span<const can::Filter> filters) {
      return bus.attach(can::TransmitOrder::by_priority, filters);
    };
  }
  can::SimBus bus;
  std::unique_ptr<can::Bus> tester;
  std::unique_ptr<can::Bus> listener;
  std::vector<Received> frames;  ///< in the present cycle
};

struct Stand {
  can::Database database;
  can::BitRates rates;
  twin::Config twin;
};

Stand shipped(const char* file) {
  const config::Config config = config::load(std::string(HYSTCAN_SOURCE_DIR "/config/") + file);
  return {config.database, config.bus.rates(), twin_config(config)};
}

/// Two axes of one node, each with a separate status.
Stand with_two_statuses() {
  Stand made{can::parse_dbc(twin::shared_node_test::shared_dbc, "shared.dbc"),
             {1'000'000, 5'000'000},
             twin::shared_node_test::two_axes()};
  made.twin.axes[1].wire.frames->status->message = "StatusOfY";
  return made;
}

/// Standard frames, a lab's own frames, and two kinds of CAN FD, with nodes of all kinds.
Stand stand(unsigned number) {
  static const std::array stands{shipped("piezo.toml"), shipped("lab_amplifier.toml"),
                                 shipped("fd_stage.toml"), with_two_statuses()};
  Stand made = stands[number % stands.size()];
  twin::Config& twin = made.twin;
  const unsigned variant = number / stands.size();
  twin.seed = number;
  twin.heartbeat_period = heartbeat;
  if (twin.background_slots == 0 && variant % 2 == 1) twin.background_slots = 8;
  for (twin::WiredAxisConfig& axis : twin.axes) {
    axis.axis.command_timeout = timeout;
    axis.axis.enable_delay = std::array{relay, can::Duration::zero(), slow_relay}[variant % 3];
    axis.axis.soft_start = variant % 4 == 2 ? milliseconds(7) : can::Duration::zero();
    axis.axis.status_every = variant % 2 == 0 ? 10 : 3;
    axis.axis.watchdog_action = static_cast<node::WatchdogAction>(variant % 4);
    axis.axis.interpolate = variant % 5 == 3;
    axis.axis.sensor.range_max_um = 20.0;
    if (axis.wire.frames)
      for (can::MessageMap* map : {&axis.wire.frames->command, &axis.wire.frames->sample})
        map->data_id = {.kind = static_cast<can::DataId::Kind>(variant % 3), .number = 0x10A1};
    if (variant % 7 == 5) axis.axis.sensor.offset_um = 1995.0;  // some positions do not fit the signal
  }
  if (variant % 6 == 4 && twin.axes.back().wire.frames) twin.axes.back().wire.frames->status.reset();
  return made;
}

/// The number of all frames, and of some kinds.
using Counts = std::map<std::string, int>;

class Comparison {
 public:
  /// `firmware` is a modified configuration for the nodes of the firmware.
  Comparison(std::uint64_t seed, const Stand& stand, const twin::Config& firmware)
      : twin_side_(clock_, stand.rates),
        firmware_side_(clock_, stand.rates),
        twin_(stand.twin, stand.database, clock_, twin_side_.attach()),
        nodes_(firmware, stand.database, clock_, firmware_side_.attach()),
        traffic_(seed, stand.twin, stand.database),
        cycle_(stand.twin.cycle),
        heartbeats_of_others_(stand.twin.axes.front().wire.amplifier_node) {
    twin_side_.listen();
    firmware_side_.listen();
    twin_.start();
    clock_.run_until(clock_.now() + stand.twin.heartbeat_period);
    nodes_.start();
    clock_.run_until(can::Time{} + std::chrono::ceil<milliseconds>(clock_.now().time_since_epoch()));
  }

  /// Returns the first difference, if any. `counts`: frames of the twin's nodes.
  std::optional<std::string> run(int cycles, Counts& counts) {
    for (int i = 0; i < cycles; ++i) {
      step();
      if (i == cycles - 150 && traffic_.chance(0.5))
        send(can::heartbeat_frame(heartbeats_of_others_, can::NmtState::operational));
      if (const auto found = compare(counts)) return "cycle " + std::to_string(i) + ": " + *found;
    }
    for (const can::Bus* bus : twin_.station().connections())
      counts["frames"] += static_cast<int>(bus->counters().sent);
    return std::nullopt;
  }

 private:
  void send(const can::Frame& frame) {
    twin_side_.tester->send(frame);
    firmware_side_.tester->send(frame);
  }
  void step() {
    const can::Time begin = clock_.now();
    for (const Traffic::Item& item : traffic_.next_cycle()) {
      clock_.run_until(begin + item.at);
      send(item.frame);
    }
    if (traffic_.chance(0.004)) change_device();
    clock_.run_until(std::max(clock_.now(), begin + cycle_));
  }
  void change_device() {
    const std::size_t axis = traffic_.pick(static_cast<unsigned>(twin_.axes().size()));
    node::AmplifierChannel& amplifier = twin_.axes()[axis]->amplifier;
    const bool begins = traffic_.chance(0.4);
    if (traffic_.chance(0.5)) {
      begins ? amplifier.begin_internal_fault() : amplifier.end_internal_fault();
      nodes_.set_internal_fault(axis, begins);
    } else {
      begins ? amplifier.open_relay() : amplifier.release_relay();
      nodes_.set_relay_open(axis, begins);
    }
  }
  std::optional<std::string> compare(Counts& counts) {
    const auto [twin, firmware] = std::ranges::mismatch(twin_side_.frames, firmware_side_.frames);
    if (twin != twin_side_.frames.end() || firmware != firmware_side_.frames.end()) return describe();
    for (const Received& received : twin_side_.frames) count(received.frame, counts);
    last_ = std::move(twin_side_.frames);
    twin_side_.frames.clear();
    firmware_side_.frames.clear();
    return std::nullopt;
  }
  std::string describe() const {
    std::string text;
    for (const auto& [name, frames] : {std::pair("before", &last_), std::pair("twin", &twin_side_.frames),
                                       std::pair("firmware", &firmware_side_.frames)}) {
      text += std::string("\n") + name;
      for (const Received& received : *frames) text += "\n  " + text_of(received);
    }
    return text;
  }
  static void count(const can::Frame& frame, Counts& counts) {
    const bool is_sdo =
        frame.id > 0x580 && frame.id<0x600, is_emergency = frame.id> 0x080 && frame.id < 0x100;
    if (is_emergency) ++counts[fmt::format("emergency {:04X}", frame.data[1] << 8 | frame.data[0])];
    if (is_sdo) ++counts[fmt::format("SDO {:02X}", frame.data[0] & 0xF0)];
    if (is_sdo && frame.data[0] == 0x80)
      ++counts[fmt::format("abort {:02X}{:02X}00{:02X}", frame.data[7], frame.data[6], frame.data[4])];
    if (frame.id > 0x700 && frame.length == 1) ++counts[fmt::format("heartbeat {:02X}", frame.data[0])];
  }

  can::VirtualClock clock_;
  Side twin_side_, firmware_side_;
  twin::Twin twin_;
  Nodes nodes_;
  Traffic traffic_;
  can::Duration cycle_;
  std::uint8_t heartbeats_of_others_;
  std::vector<Received> last_;
};

TEST(SameFrames, AreSentByTheFirmwareAndByTheTwin) {
  const unsigned stands = support::long_run() ? 250 : 40;
  const int cycles = support::long_run() ? 4000 : 250;
  Counts counts;
  for (unsigned i = 0; i < stands; ++i) {
    const Stand one = stand(i);
    const auto difference = Comparison(i, one, one.twin).run(cycles, counts);
    ASSERT_FALSE(difference) << "stand " << i << ", " << *difference;
  }
  for (const char* kind :
       {"heartbeat 00", "heartbeat 04", "heartbeat 05", "heartbeat 7F", "SDO 40", "SDO 60", "abort 06020000",
        "abort 06070010", "emergency 0000", "emergency 5000", "emergency 6300", "emergency 8130"})
    EXPECT_GT(counts[kind], 0) << kind;
  for (const auto& [kind, count] : counts) RecordProperty(kind, count);
}

// The sensitivity of the comparison: it detects an error of a microsecond or of one.
TEST(SameFrames, DifferIfANodeIsWrong) {
  using Change = std::function<void(twin::Config&, twin::AxisConfig&)>;
  const std::map<std::string, Change> changes{
      {"watchdog", [](auto&, auto& axis) { axis.command_timeout += microseconds(1); }},
      {"relay", [](auto&, auto& axis) { axis.enable_delay += microseconds(1); }},
      {"heartbeat", [](auto& config, auto&) { config.heartbeat_period += microseconds(1); }},
      {"stale commands", [](auto& config, auto&) { config.cycle += microseconds(200); }},
      {"status", [](auto&, auto& axis) { ++axis.status_every; }},
      {"slots", [](auto& config, auto&) { config.background_slots = 8; }},
      {"largest setpoint", [](auto&, auto& axis) { axis.plant.amplifier.drive_max += 0.002; }}};
  const Stand right = stand(0);
  for (const auto& [name, change] : changes) {
    twin::Config wrong = right.twin;
    for (twin::WiredAxisConfig& axis : wrong.axes) change(wrong, axis.axis);
    Counts counts;
    EXPECT_TRUE(Comparison(1, right, wrong).run(10'000, counts)) << name;
  }
}

}  // namespace
}  // namespace hystcan::firmware::same_frames_test
