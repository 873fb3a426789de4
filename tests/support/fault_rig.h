// Controller and twin of one axis on the simulated bus, with a hand on everything that can go wrong between
// them: each node's connection is wrapped, the controller's scheduler too, a tester sends what others would.
//
// Troubles begin and end while the loop runs, any number of them at once. A WireMonitor listens throughout.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/oversleeper.h"
#include "tests/support/wire_monitor.h"

namespace hystcan::support {

enum class Trouble : std::uint8_t {
  sample_lost,
  sample_late,     ///< each comes in the place of the next
  sample_frozen,   ///< the value, not the counters
  counter_frozen,  ///< of the message, so that it is rejected
  sample_jumped,   ///< by 8 um
  sample_beyond,   ///< 60 um, outside position_max_um
  sample_bad,      ///< Status is not 0
  sample_damaged,  ///< wrong CRC
  sensor_emergency,
  sensor_unheard,     ///< its heartbeats are lost, its samples are not
  amplifier_unheard,  ///< its heartbeats and statuses
  sensor_stopped,     ///< NMT stop, by somebody else
  amplifier_stopped,
  sensor_reset,
  amplifier_reset,
  amplifier_trips,  ///< its status says fault
  commands_lost,    ///< on their way to the amplifier: its watchdog trips
  enable_lost,      ///< Enable does not reach the amplifier
  bus_passive,
  bus_off,
  interface_down,
  position_drifts,  ///< 1 um a cycle, up to 7.5 um: the stage is not where the reference is
  load_pulls,       ///< 0.05 um a cycle, up to 7 um: there is no drive that would get there
  sync_late,        ///< each by half a cycle
  stall,            ///< one SYNC 20 cycles late
  foreign_sync,
  foreign_heartbeat,
  law_not_finite,  ///< a gain that is not a number
};
inline constexpr std::size_t trouble_count = 28;
std::string_view to_string(Trouble trouble);

/// A connection whose frames can be changed or taken away: a hook gives false for those.
class Relay final : public can::Bus {
 public:
  using Hook = std::function<bool(can::Frame& frame)>;
  Relay(std::unique_ptr<can::Bus> inner, Hook on_send, Hook on_receive);

  /// The state that the owner sees in the place of the true one. Down: nothing passes.
  void pretend(std::optional<can::BusState> state);
  /// Called after each frame that the owner has handled, with its time.
  std::function<void(can::Time received)> after_frame;

  bool send(const can::Frame& frame) override;
  void on_frame(FrameHandler handler) override;
  void on_state(StateHandler handler) override;
  can::BusState state() const override { return pretended_.value_or(inner_->state()); }
  const can::BusCounters& counters() const override { return inner_->counters(); }

 private:
  bool is_down() const { return pretended_ == can::BusState::down; }

  std::unique_ptr<can::Bus> inner_;
  Hook on_send_;
  Hook on_receive_;
  StateHandler on_state_;
  std::optional<can::BusState> pretended_;
};

/// The shipped piezo axis x alone, with a slow sine, a quick start-up and every judgement switched on.
config::Config one_axis();

/// What the wire must keep to, of the first axis.
WireMonitor::Config watch_over(const config::Config& config);

class FaultRig {
 public:
  explicit FaultRig(const config::Config& config);

  void start() { twin_->start(), controller_->start(); }
  void run_for(can::Duration time);
  /// False: it did not come to that within `limit`.
  bool reaches(controller::AxisState state, can::Duration limit);
  bool tracks(can::Duration limit = std::chrono::seconds(5)) {
    return reaches(controller::AxisState::tracking, limit);
  }

  void begin(Trouble trouble);
  void end(Trouble trouble);
  bool is_on(Trouble trouble) const { return on_[static_cast<std::size_t>(trouble)]; }

  /// By RequestLink, as `hystcan ctl` does. Empty: done.
  std::string_view ask(controller::Request::Kind kind);
  std::string_view retune(const controller::AxisConfig& next);

  const controller::Axis& axis() const { return std::as_const(*controller_).axis(0); }
  controller::Controller& controller() { return *controller_; }
  twin::Twin::Axis& stage() { return *twin_->axes()[0]; }
  twin::FaultScheduler& stage_faults() { return twin_->faults(); }
  can::VirtualClock& clock() { return clock_; }
  WireMonitor& monitor() { return *monitor_; }
  const WireMonitor& monitor() const { return *monitor_; }
  const config::Config& config() const { return config_; }
  void send(const can::Frame& frame) { tester_->send(frame); }

  std::uint64_t faults() const { return faults_; }
  /// When the last fault was decided: the end of the frame that decided it, or the SYNC that found it.
  can::Time decided_at() const { return decided_at_; }

 private:
  std::unique_ptr<can::Bus> attach_node(std::span<const can::Filter> filters);
  void note_fault(can::Time when);
  bool sensor_sends(can::Frame& frame);
  bool spoil_sample(can::Frame& frame);
  bool amplifier_sends(can::Frame& frame);
  bool amplifier_hears(can::Frame& frame);
  std::string_view answer_to(std::unique_ptr<controller::Request> request);

  config::Config config_;
  std::array<bool, trouble_count> on_{};
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, 1'000'000};
  Oversleeper sleeper_{clock_};
  std::optional<WireMonitor> monitor_;
  std::unique_ptr<can::Bus> monitor_bus_;
  std::unique_ptr<can::Bus> tester_;
  controller::RequestLink requests_;
  std::unique_ptr<twin::Twin> twin_;
  can::SimNode* controller_node_ = nullptr;
  Relay* controller_relay_ = nullptr;
  std::unique_ptr<controller::Controller> controller_;
  std::optional<can::Frame> held_sample_;
  std::int32_t frozen_value_ = 0;
  std::uint8_t frozen_counter_ = 0;
  double offset_um_ = 0.0;
  bool was_faulted_ = false;
  std::uint64_t faults_ = 0;
  can::Time decided_at_{};
};

}  // namespace hystcan::support
