// The twin on a simulated bus, for tests that use only frames.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "can/protocol/protocol.h"
#include "can/sim/sim_bus.h"
#include "tests/support/piezo.h"
#include "twin/twin.h"

namespace hystcan::twin {

inline Config one_axis() {
  Config config;
  config.heartbeat_period = std::chrono::milliseconds(100);
  WiredAxisConfig& x = config.axes.emplace_back();
  x.wire = {.name = "x", .message_prefix = "X", .amplifier_node = 1, .sensor_node = 2};
  x.axis.plant = {
      .hysteresis = support::piezo_model(),
      .mode = {.natural_frequency_Hz = 500.0, .damping_ratio = 0.05},
      .amplifier = {
          .drive_min = -20, .drive_max = 120, .slew_per_s = 93e3, .bandwidth_Hz = 1500, .safe_drive = 0}};
  x.axis.command_timeout = std::chrono::milliseconds(20);
  return config;
}

/// A sender that ignores the limits of the DBC.
inline can::Message without_limits(can::Message message) {
  for (can::Signal& signal : message.signals) signal.minimum = signal.maximum = 0.0;
  return message;
}

/// A bus, and a tester that sends on it in place of the controller.
class NodeTester {
 public:
  explicit NodeTester(const can::BitRates& rates = {1'000'000}) : bus_(clock_, rates) {}

  void start_nodes() {
    tester_->send(can::nmt_frame({can::NmtCommand::start, 0}));
    run(std::chrono::milliseconds(1));
  }
  void run(can::Duration duration) { clock_.run_until(clock_.now() + duration); }
  void sync() { tester_->send(can::sync_frame(counter_ = can::next_sync_counter(counter_))); }
  /// A SYNC without a command.
  void cycle() {
    sync();
    run(std::chrono::milliseconds(1));
  }

  can::VirtualClock clock_;
  can::SimBus bus_;
  std::unique_ptr<can::Bus> tester_ = bus_.attach();
  std::map<std::uint32_t, int> heard_;
  std::uint8_t counter_ = 0;
};

/// A bus with the twin, and a tester that stores the received frames. The nodes have booted up.
class TwinBench : public NodeTester {
 public:
  explicit TwinBench(const Config& config = one_axis())
      : twin_(config, database_, clock_, [this](auto) { return bus_.attach(); }) {
    tester_->on_frame([this](const can::Frame& frame, can::Time) {
      ++heard_[frame.id];
      if (frame.id == 0x181)
        if (const auto decoded = decode_status_(frame)) status_ = *decoded;
      if (frame.id == 0x182)
        if (const auto decoded = decode_sample_(frame)) sample_ = *decoded;
      if (frame.id == 0x701) amplifier_heartbeats_.push_back(frame.data[0]);
      if (frame.id == 0x081) emergencies_.push_back(can::parse_emergency(frame)->code);
    });
    twin_.start();
    run(config.heartbeat_period);  // the twin listens
  }

  void command(double setpoint, bool enable, bool clear_fault = false) {
    tester_->send(*encode_command_(
        {.setpoint = setpoint, .enable = enable, .clear_fault = clear_fault, .sync_counter = counter_}));
  }
  /// Sends SYNC and command, once a millisecond.
  void drive(double setpoint, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      sync();
      command(setpoint, true);
      run(std::chrono::milliseconds(1));
    }
  }
  double output() {
    run(std::chrono::milliseconds(5));
    Plant& plant = twin_.axes().front()->plant;
    plant.advance_to(clock_.now());
    return plant.drive();
  }

  can::Database database_ = can::load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  can::Encoder<can::AmpCommand> encode_command_{without_limits(*database_.find("XAmpCommand"))};
  can::Decoder<can::AmpStatus> decode_status_{*database_.find("XAmpStatus")};
  can::Decoder<can::SensorSample> decode_sample_{*database_.find("XSensorSample")};
  Twin twin_;
  std::vector<int> amplifier_heartbeats_;
  std::vector<int> emergencies_;
  std::optional<can::AmpStatus> status_;
  std::optional<can::SensorSample> sample_;
};

}  // namespace hystcan::twin
