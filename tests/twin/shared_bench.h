// Two axes served by one amplifier node and one sensor node, in the same CAN FD frames, for tests that use
// only frames.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/twin/twin_bench.h"

namespace hystcan::twin::shared_node_test {

/// Both axes are in each frame, or y has a separate status.
inline constexpr const char* shared_dbc = R"(
BO_ 513 Command: 16 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ EnableX : 20|1@1+ (1,0) [0|0] "" X
 SG_ ClearX : 21|1@1+ (1,0) [0|0] "" X
 SG_ EnableY : 22|1@1+ (1,0) [0|0] "" X
 SG_ ClearY : 23|1@1+ (1,0) [0|0] "" X
 SG_ SyncCounter : 24|8@1+ (1,0) [0|0] "" X
 SG_ SetX : 32|32@1- (0.001,0) [0|0] "V" X
 SG_ SetY : 64|32@1- (0.001,0) [0|0] "V" X

BO_ 385 Status: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateX : 20|2@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultX : 24|8@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|2@1+ (1,0) [0|0] "" X
 SG_ OutX : 40|16@1- (0.01,0) [0|0] "V" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 641 StatusOfY: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 24|32@1+ (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 642 StatusOfYWithoutFault: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|1@1- (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 2147484033 StatusOfYExtended: 12 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ StateY : 22|2@1+ (1,0) [0|0] "" X
 SG_ FaultY : 32|8@1+ (1,0) [0|0] "" X
 SG_ OutY : 56|16@1- (0.01,0) [0|0] "V" X

BO_ 386 Sample: 16 Vector__XXX
 SG_ Crc : 0|16@1+ (1,0) [0|0] "" X
 SG_ Counter : 16|4@1+ (1,0) [0|0] "" X
 SG_ BadX : 20|1@1+ (1,0) [0|0] "" X
 SG_ BadY : 21|1@1+ (1,0) [0|0] "" X
 SG_ SyncCounter : 24|8@1+ (1,0) [0|0] "" X
 SG_ PosX : 32|32@1- (0.000001,0) [0|0] "um" X
 SG_ PosY : 64|32@1- (0.000001,0) [0|0] "um" X
)";

inline can::AxisFrames frames_of(const std::string& axis) {
  const auto map = [](const char* message, std::map<std::string, std::string, std::less<>> signals) {
    return can::MessageMap{.message = message, .signals = std::move(signals), .polynomial = can::Crc::crc16};
  };
  return {
      .command = map("Command", {{"setpoint", "Set" + axis},
                                 {"enable", "Enable" + axis},
                                 {"clear_fault", "Clear" + axis},
                                 {"sync_counter", "SyncCounter"}}),
      .status =
          map("Status", {{"output", "Out" + axis}, {"state", "State" + axis}, {"fault", "Fault" + axis}}),
      .sample = map("Sample",
                    {{"position", "Pos" + axis}, {"sync_counter", "SyncCounter"}, {"status", "Bad" + axis}})};
}

/// Both axes are served by amplifier node 1 and sensor node 2.
inline Config two_axes() {
  Config config = one_axis();
  config.axes.push_back(config.axes[0]);
  config.axes[0].wire.frames = frames_of("X");
  config.axes[1].wire.frames = frames_of("Y");
  config.axes[1].wire.name = "y";
  return config;
}

inline constexpr std::size_t x = 0;
inline constexpr std::size_t y = 1;

class SharedBench : public NodeTester {
 public:
  explicit SharedBench(const Config& config = two_axes())
      : NodeTester({1'000'000, 5'000'000}),
        twin_(config, database_, clock_, [this](auto) { return bus_.attach(); }) {
    for (const std::size_t axis : {x, y}) {
      command_.push_back(*can::find_layout<can::AmpCommand>(database_, config.axes[axis].wire));
      const auto status = can::find_layout<can::AmpStatus>(database_, config.axes[axis].wire);
      status_.push_back(status ? std::optional(can::Decoder(*status)) : std::nullopt);
      sample_.emplace_back(*can::find_layout<can::SensorSample>(database_, config.axes[axis].wire));
    }
    tester_->on_frame([this](const can::Frame& frame, can::Time) {
      ++heard_[frame.id];
      if (frame.id == 0x081) emergency_ = *can::parse_emergency(frame);
      for (const std::size_t axis : {x, y}) {
        if (frame.id == sample_[axis].id()) samples_[axis] = sample_[axis](frame);
        if (status_[axis] && frame.id == status_[axis]->id()) statuses_[axis] = (*status_[axis])(frame);
      }
    });
    twin_.start();
    run(config.heartbeat_period);  // the twin listens
  }

  void command(std::array<can::AmpCommand, 2> commands) {
    can::Frame frame = command_[x].frame();
    for (const std::size_t axis : {x, y}) {
      commands[axis].sync_counter = counter_;
      ASSERT_TRUE(command_[axis].put(commands[axis], frame));
    }
    protector_.seal(frame);
    tester_->send(frame);
  }
  /// Sends SYNC and command once a millisecond, with enough time to arrive.
  void drive(std::array<can::AmpCommand, 2> commands, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      sync();
      command(commands);
      run(std::chrono::milliseconds(1));
    }
  }
  void drive(double to_x, double to_y, int cycles = 10) {
    drive({can::AmpCommand{.setpoint = to_x, .enable = true},
           can::AmpCommand{.setpoint = to_y, .enable = true}},
          cycles);
  }
  const Axis& axis(std::size_t index) { return *twin_.axes()[index]; }
  node::AmplifierChannel& amplifier(std::size_t index) { return twin_.axes()[index]->amplifier; }
  void inject(Fault kind, const std::string& axis, Node node, std::optional<double> value = {}) {
    FaultSpec spec = fault_spec(kind, axis);
    spec.node = node;
    if (value) spec.value = *value;
    twin_.faults().inject(spec);
  }

  can::Database database_ = can::parse_dbc(shared_dbc, "shared.dbc");
  Twin twin_;
  std::vector<can::Layout<can::AmpCommand>> command_;
  std::vector<std::optional<can::Decoder<can::AmpStatus>>> status_;
  std::vector<can::Decoder<can::SensorSample>> sample_;
  can::E2eProtector protector_{
      can::protection_of(*database_.find("Command"), two_axes().axes[0].wire.frames->command)};
  std::array<std::optional<can::AmpStatus>, 2> statuses_;
  std::array<std::optional<can::SensorSample>, 2> samples_;
  can::Emergency emergency_;
};

}  // namespace hystcan::twin::shared_node_test
