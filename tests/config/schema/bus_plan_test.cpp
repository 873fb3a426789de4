#include "config/schema/bus_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <string>

#include "can/sim/sim_bus.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::bus_plan_test {
namespace {

using namespace std::chrono_literals;

Config shipped(const char* name) { return load(std::string(HYSTCAN_SOURCE_DIR "/config/") + name); }

const PlannedFrame& planned(const BusPlan& plan, const std::string& name) {
  return *std::ranges::find(plan.frames, name, [](const PlannedFrame& p) { return p.frame.name; });
}

TEST(BusPlan, OfTheShippedStageFitsAndMatchesACountByHand) {
  const BusPlan plan = plan_bus(shipped("piezo.toml"));
  EXPECT_EQ(plan.frames.size(), 14U);
  EXPECT_EQ(plan.emergencies.size(), 4U);
  // Behind a full cycle, 655 with turnaround, that had both amplifiers' statuses, 270, all five heartbeats,
  // 325, and one of the controller's axis statuses, 135; the controller's in its queue before this SYNC.
  EXPECT_EQ(planned(plan, "Sync").response, 655us + 270us + 325us + 135us + 65us - 1000us);
  // SYNC, sample, command: 65 + 135 + 135; turnaround 50; the other axis's sample and command 270; both
  // statuses 270; a heartbeat of 65 bits before each of the three.
  EXPECT_EQ(planned(plan, "YAmpCommand").response, 335us + 50us + 270us + 270us + 195us);
  EXPECT_EQ(planned(plan, "YAmpCommand").deadline, 1135us);
  EXPECT_TRUE(plan.commands_in_time());
  for (const PlannedFrame& frame : plan.frames) EXPECT_TRUE(frame.in_time()) << frame.frame.name;
  // 65 + 4 * 135 bits in each of 1000 cycles, two statuses in every tenth, five heartbeats and two axis
  // statuses in 100 ms.
  EXPECT_NEAR(plan.load, (605.0 * 1000 + 2 * 135 * 100 + (5 * 65 + 2 * 135) * 10) / 1e6, 1e-9);
  EXPECT_LT(plan.load, 2.0 / 3.0);
}

// Any node's frame may be on the bus when a sample or a command is queued: here two live setpoints of 135
// bits instead of two heartbeats of 65.
TEST(BusPlan, CountsTheLiveSetpointsOfOtherNodes) {
  Config config = shipped("piezo.toml");
  config.controller.rate_Hz = 800.0;
  const can::Duration before = *plan_bus(config).last_command;
  for (AxisConfig& axis : config.axes) axis.live_setpoint = true;
  const BusPlan plan = plan_bus(config);
  EXPECT_EQ(plan.frames.size(), 16U);
  EXPECT_EQ(*plan.last_command, before + 140us);
  EXPECT_TRUE(plan.commands_in_time());
  config.controller.rate_Hz = 1000.0;
  EXPECT_FALSE(plan_bus(config).commands_in_time()) << "two axes leave no room for them at 1 Mbit/s";
}

// The statuses of all axes take turns, one per cycle: more axes do not give more of them in a cycle.
TEST(BusPlan, DelaysNoCommandByTheControllersStatuses) {
  Config config = shipped("piezo.toml");
  const can::Duration with = *plan_bus(config).last_command;
  std::erase_if(config.database.messages,
                [](const can::Message& message) { return message.name.ends_with("ControllerStatus"); });
  EXPECT_EQ(plan_bus(config).frames.size(), 12U);
  EXPECT_EQ(*plan_bus(config).last_command, with);
}

TEST(BusPlan, OfOneAxisHasSpareTime) {
  const BusPlan plan = plan_bus(shipped("galfenol.toml"));
  EXPECT_LT(*plan.last_command, 600us);
}

TEST(BusPlan, ReportsAnOverloadedBus) {
  Config config = shipped("piezo.toml");
  config.bus.bitrate_bit_per_s = 250'000;
  const BusPlan plan = plan_bus(config);
  EXPECT_GT(plan.load, 1.0);
  EXPECT_FALSE(plan.last_command);
  EXPECT_FALSE(plan.commands_in_time());
}

void expect_refused(const char* what, const char* with, const std::string& line, const std::string& message) {
  const support::ShippedCopy copy;
  copy.edit("piezo.toml", what, with);
  const std::string refusal = support::refusal_of([&] { load(copy / "piezo.toml"); });
  EXPECT_NE(refusal.find(":" + line + ":"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find(message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("Hz fits), raise bus.bitrate_bit_per_s or drive fewer axes"), std::string::npos)
      << refusal;
}

TEST(BusPlan, WithLateCommandsIsRefusedAtTheRate) {
  expect_refused("1_000_000", "800_000", "16", "the last command may begin as late as");
  expect_refused("1_000_000", "125_000", "16", "the bus is loaded to 510 % of 125000 bit/s");
  expect_refused("\"hystcan.dbc\"", "\"hystcan.dbc\"\nturnaround_us = 100.0", "17",
                 "expected within the cycle");
}

/// The nodes of a configuration in the worst case: longest frames, random phases and work times, heartbeats
/// and statuses at the worst moment. Each frame has a node of its own, so that the most urgent frame goes
/// first.
class Traffic {
 public:
  Traffic(const Config& config, std::uint64_t seed)
      : wire_(clock_, config.bus.rates()), random_(seed), plan_(plan_bus(config)), config_(config) {
    for (const PlannedFrame& each : plan_.frames) {
      const std::string& name = each.frame.name;
      nodes_[name] = wire_.attach();
      if (name == "Sync" || (name.ends_with("Heartbeat") && name != "ControllerHeartbeat"))
        repeat(each, name == "Sync" ? 0ns : upto(each.frame.period));
    }
    for (const AxisConfig& axis : config.axes)
      samples_of_[can::message_map<can::AmpCommand>(axis.wire)->message].insert(
          can::message_map<can::SensorSample>(axis.wire)->message);
    ear_ = wire_.attach();
    ear_->on_frame([this](const can::Frame& frame, can::Time when) { hear(frame, when); });
  }

  void run(can::Duration length) { clock_.run_until(can::Time{length}); }
  can::Duration longest(const std::string& name) const {
    const auto found = longest_.find(name);
    return found == longest_.end() ? 0ns : found->second;
  }
  const BusPlan& plan() const { return plan_; }

 private:
  can::Duration upto(can::Duration limit) {
    return can::Duration{static_cast<can::Duration::rep>(
        random_() % static_cast<std::uint64_t>(std::max<can::Duration::rep>(limit.count(), 1)))};
  }

  void repeat(const PlannedFrame& each, can::Duration phase) {
    auto due = std::make_shared<can::Time>(phase);
    auto index = timers_.size();
    timers_.push_back(clock_.make_timer([this, due, index, frame = each.frame] {
      if (frame.name == "Sync") cycle_began_.push_back(clock_.now());
      send(frame);
      *due += frame.period;
      timers_[index]->expire_at(*due);
    }));
    timers_.back()->expire_at(*due);
  }

  void send(const can::PeriodicFrame& of) {
    can::Frame frame{.id = of.id,
                     .extended = of.extended,
                     .kind = can::wire_kind(of.bytes, of.fd),
                     .length = static_cast<std::uint8_t>(of.bytes),
                     .fd_flags = of.bit_rate_switch ? can::fd_bit_rate_switch : std::uint8_t{0}};
    frame.data.fill(static_cast<std::uint8_t>(random_() % 2 == 0 ? 0x3C : 0x00));
    ASSERT_TRUE(nodes_[of.name]->send(frame));
  }

  void after(can::Duration wait, const can::PeriodicFrame& frame) {
    timers_.push_back(clock_.make_timer([this, frame] { send(frame); }));
    timers_.back()->expire_at(clock_.now() + wait);
  }

  void hear(const can::Frame& frame, can::Time when) {
    const auto at = std::ranges::find(plan_.frames, frame.id, [](const auto& p) { return p.frame.id; });
    const std::string& name = at->frame.name;
    const can::Duration part = config_.bus.turnaround / 2;
    if (name != "Sync" && !name.ends_with("Sample") && !name.ends_with("Command")) return;
    const std::size_t cycle = heard_[name]++;
    if (name == "Sync") {
      for (const PlannedFrame& each : plan_.frames) {
        if (each.frame.name.ends_with("Sample")) after(upto(part + 1ns), each.frame);
        if (each.frame.name.ends_with("AmpStatus") && cycle_began_.size() % 10 == 0)
          after(upto(part + 1ns), each.frame);
      }
    }
    if (name.ends_with("Sample")) answer(cycle, part);
    if (name.ends_with("Command") && ++commands_ % samples_of_.size() == 0) send_own_frames();
    const can::Time began = cycle_began_.at(cycle);
    const can::Duration interframe{3'000'000'000 / config_.bus.bitrate_bit_per_s};
    longest_[name] = std::max(longest_[name], when + interframe - began);
  }

  /// Queues each command whose last sample of this cycle has come.
  void answer(std::size_t cycle, can::Duration work) {
    for (const auto& [command, samples] : samples_of_) {
      if (answered_[command] > cycle ||
          std::ranges::any_of(samples, [&](const std::string& each) { return heard_[each] <= cycle; }))
        continue;
      ++answered_[command];
      after(upto(work + 1ns), planned(plan_, command).frame);
    }
  }

  /// Behind the commands of a cycle: the axis statuses in turn, and the controller's heartbeat.
  void send_own_frames() {
    const std::size_t axes = config_.axes.size();
    if (commands_ % (7 * samples_of_.size()) == 0)
      send(planned(plan_, config_.axes[turn_++ % axes].wire.message_prefix + "ControllerStatus").frame);
    if (cycle_began_.back() < next_heartbeat_) return;
    const can::PeriodicFrame& heartbeat = planned(plan_, "ControllerHeartbeat").frame;
    next_heartbeat_ = cycle_began_.back() + heartbeat.period;
    send(heartbeat);
  }

  can::VirtualClock clock_;
  can::SimBus wire_;
  std::mt19937_64 random_;
  BusPlan plan_;
  const Config& config_;
  std::map<std::string, std::unique_ptr<can::Bus>> nodes_;
  std::unique_ptr<can::Bus> ear_;
  std::vector<std::unique_ptr<can::Timer>> timers_;
  std::vector<can::Time> cycle_began_;
  std::map<std::string, std::set<std::string>> samples_of_;  ///< by the command that waits for them
  std::map<std::string, std::size_t> heard_;
  std::map<std::string, std::size_t> answered_;  ///< commands that are queued, as cycles
  can::Time next_heartbeat_{};
  std::size_t commands_ = 0;
  std::size_t turn_ = 0;
  std::map<std::string, can::Duration> longest_;
};

/// The worst of the commands' longest responses, as a share of its bound; no frame exceeds its own.
double closeness(const Config& config, std::uint64_t seed) {
  Traffic traffic(config, seed);
  double closest = 0.0;
  if (!traffic.plan().last_command) return closest;
  traffic.run(500ms);
  for (const PlannedFrame& each : traffic.plan().frames) {
    const can::Duration seen = traffic.longest(each.frame.name);
    EXPECT_LE(seen, *each.response) << each.frame.name << " with seed " << seed;
    if (each.frame.name.ends_with("Command"))
      closest = std::max(closest, can::seconds(seen) / can::seconds(*each.response));
  }
  return closest;
}

void set_times(Config& config, std::mt19937_64& random) {
  config.twin.heartbeat_period =
      can::Duration{static_cast<can::Duration::rep>(5'000'000 + random() % 9'000'000)};
  config.controller.heartbeat_period = 7ms;
  config.bus.turnaround = can::Duration{static_cast<can::Duration::rep>(random() % 100'000)};
}

TEST(BusPlan, IsNeverExceededByTheSimulatedBus) {
  std::mt19937_64 random(5);
  double closest = 0.0;
  for (int round = 0; round < 60 && !HasFailure(); ++round) {
    Config config = shipped(round % 3 == 0 ? "galfenol.toml" : "piezo.toml");
    config.controller.rate_Hz = 400.0 + static_cast<double>(random() % 600);
    config.bus.bitrate_bit_per_s = random() % 2 == 0 ? 1'000'000 : 800'000;
    set_times(config, random);
    closest = std::max(closest, closeness(config, random()));
  }
  EXPECT_GT(closest, 0.6) << "the bound is not an empty one";
  EXPECT_LT(closest, 1.0);
  RecordProperty("closest", std::to_string(closest));
}

/// Axes that share samples and commands at random, each sample and command in a frame of CAN FD.
Config shared_at_random(std::mt19937_64& random) {
  Config config = shipped("piezo.toml");
  const AxisConfig like = config.axes.front();
  config.axes.clear();
  config.database.messages.clear();
  const auto share = [&](const std::string& name, std::uint32_t id) {
    auto message = std::ranges::find(config.database.messages, name, &can::Message::name);
    if (message == config.database.messages.end()) {
      message = config.database.messages.emplace(message);
      message->name = name;
      message->id = id;
      message->length = 4;
      message->fd = true;
      message->bit_rate_switch = random() % 4 != 0;
    }
    message->length = static_cast<std::uint16_t>(message->length + 3);
    return can::MessageMap{.message = name};
  };
  const std::size_t axes = 1 + random() % 8;
  const unsigned groups = 1 + static_cast<unsigned>(random() % 4);
  for (std::size_t i = 0; i < axes; ++i) {
    AxisConfig& axis = config.axes.emplace_back(like);
    const auto amplifier = static_cast<unsigned>(random() % groups);
    const auto sensor = static_cast<unsigned>(random() % groups);
    axis.wire.message_prefix = fmt::format("A{}", i);
    axis.wire.amplifier_node = static_cast<std::uint8_t>(1 + amplifier);
    axis.wire.sensor_node = static_cast<std::uint8_t>(33 + sensor);
    axis.wire.frames.emplace();
    axis.wire.frames->command = share(fmt::format("Of{}AmpCommand", amplifier), 0x201 + amplifier);
    axis.wire.frames->status = share(fmt::format("Of{}AmpStatus", amplifier), 0x181 + amplifier);
    axis.wire.frames->sample = share(fmt::format("Of{}Sample", sensor), 0x1A1 + sensor);
    share(axis.wire.message_prefix + "ControllerStatus", 0x2C1 + static_cast<std::uint32_t>(i));
  }
  config.bus.data_bitrate_bit_per_s = 5'000'000;
  return config;
}

TEST(BusPlan, OfAxesThatShareFramesIsNeverExceededByTheSimulatedBus) {
  std::mt19937_64 random(6);
  double closest = 0.0;
  for (int round = 0; round < 60 && !HasFailure(); ++round) {
    Config config = shared_at_random(random);
    config.controller.rate_Hz = 500.0 + static_cast<double>(random() % 2000);
    set_times(config, random);
    closest = std::max(closest, closeness(config, random()));
  }
  EXPECT_GT(closest, 0.6) << "the bound is not an empty one";
  RecordProperty("closest", std::to_string(closest));
}

TEST(BusPlan, HasEachFrameAndEachNodeOnceThatAxesShare) {
  std::mt19937_64 random(6);
  Config config = shared_at_random(random);
  const AxisConfig first = config.axes.front();
  config.axes = {first, first};
  config.axes.back().wire.message_prefix = "A1";
  const BusPlan plan = plan_bus(config);
  // SYNC, sample, command, status, two heartbeats and the controller's; its status of the one axis that the
  // database has.
  EXPECT_EQ(plan.frames.size(), 8U);
  EXPECT_EQ(plan.emergencies.size(), 2U);
}

TEST(Wiring, OfTwoClassicalAxesIsThatOfTheShippedStage) {
  const Config stage = shipped("piezo.toml");
  const BusPlan plan = plan_bus(wired_as(Wiring::classical, 2, stage));
  EXPECT_EQ(plan.last_command, plan_bus(stage).last_command);
  EXPECT_DOUBLE_EQ(plan.load, plan_bus(stage).load);
}

TEST(Wiring, OfAxesInOneFrameMatchesACountByHand) {
  const auto last_command = [](std::size_t axes, double rate_Hz) {
    Config config = wired_as(Wiring::fd_shared, axes, shipped("piezo.toml"));
    config.controller.rate_Hz = rate_Hz;
    return plan_bus(config).last_command;
  };
  // SYNC 65, turnaround 50; sample and status of 10 bytes in frames of 12, 32 + 154 / 5; two heartbeats, 130.
  EXPECT_EQ(last_command(2, 2500.0), 65us + 50us + 2 * 62'800ns + 130us);
  // Of 28 bytes in frames of 32: 32 + 359 / 5.
  EXPECT_EQ(last_command(8, 2000.0), 65us + 50us + 2 * 103'800ns + 130us);
}

TEST(Wiring, WithSlotsMeetsOneFrameOfABackgroundInsteadOfThree) {
  Config config = wired_as(Wiring::fd_slots, 2, shipped("piezo.toml"));
  config.controller.rate_Hz = 4000.0;
  EXPECT_EQ(plan_bus(config).last_command, 65us + 50us + 62'800ns + 65us);
}

TEST(Wiring, LeavesOutTheNodeOfTheController) {
  Config config = shipped("piezo.toml");
  config.controller.node = 3;
  EXPECT_EQ(plan_bus(wired_as(Wiring::classical, 16, config)).frames.size(), 16U * 6 + 2);
}

TEST(FastestRate, FitsAndTheNextStepDoesNot) {
  for (const Wiring wiring : {Wiring::classical, Wiring::fd, Wiring::fd_shared, Wiring::fd_slots}) {
    Config config = wired_as(wiring, 3, shipped("piezo.toml"));
    config.controller.rate_Hz = rate_max_Hz;
    const double fastest_Hz = fastest_rate_Hz(config);
    EXPECT_EQ(std::fmod(fastest_Hz, 10.0), 0.0);
    config.controller.rate_Hz = fastest_Hz;
    EXPECT_TRUE(plan_bus(config).commands_in_time()) << fastest_Hz;
    config.controller.rate_Hz = fastest_Hz + 10.0;
    EXPECT_FALSE(plan_bus(config).commands_in_time()) << fastest_Hz;
  }
}

TEST(FastestRate, IsTheConfiguredOneWhereThatFits) {
  EXPECT_EQ(fastest_rate_Hz(shipped("galfenol.toml")), 1000.0);
}

}  // namespace
}  // namespace hystcan::config::bus_plan_test
