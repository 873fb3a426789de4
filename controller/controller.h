// The controller as a node on the bus: sends the SYNC, receives samples, sends commands; one Axis for each
// axis.
//
//   SYNC(n) -> SensorSample(n) -> Axis::step -> AmpCommand(n)
//
// A sample is answered as it arrives. If it has not come by the next SYNC, the axis is stepped without it
// then, and the sample is counted as missing. A command frame of several axes goes out when all of them have
// stepped, and at the latest at a deadline in the cycle: those that have no sample by then are stepped
// without it. An axis whose samples have stayed away for some cycles is not waited for.
//
// The other frames of the controller follow its commands (BackgroundFrames), and so does the answer to a
// request from outside (carry_out). When a SYNC is due, and when the axes begin to track: SyncClock,
// TogetherStart.
//
// Before its first frame the controller listens for one heartbeat period. Four kinds of frame show another
// controller: a SYNC, a heartbeat of the own node id, an axis status, and a command to one of the own
// amplifiers. Each of them faults every axis, and the log names the frame. If the controller receives it
// while it listens, it stays silent permanently; later, its commands are safe from there on. An NMT command
// or an SDO write of another node to a node of an axis in use faults this axis.
//
// Bus-off, or the loss of the interface, faults every driven axis with the next step. What was known of the
// nodes is forgotten: a node must be heard again before its axis is armed again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "controller/background_frames.h"
#include "controller/black_box.h"
#include "controller/cycle_record.h"
#include "controller/realtime.h"
#include "controller/requests.h"
#include "controller/shared_frames.h"
#include "controller/sync_clock.h"
#include "controller/timing.h"
#include "controller/together_start.h"
#include "controller/wired_axis.h"

namespace hystcan::controller {

/// What holds for the controller as a whole.
struct CommonConfig {
  double rate_Hz = 1000.0;
  std::uint8_t node = 127;  ///< Of the controller's own heartbeat.
  can::Duration heartbeat_period{std::chrono::milliseconds(100)};
  can::Duration heartbeat_timeout{std::chrono::milliseconds(300)};  ///< Of the other nodes.
  can::Duration
      command_deadline{};  ///< Of command frames of several axes, after SYNC; zero: nine tenths of the cycle.
  unsigned background_slots = 0;  ///< Of heartbeats and statuses (can::is_in_slot); 0: none.
  can::Duration lateness_warn{};  ///< The log reports a SYNC that is later than this; zero: never.
  can::Duration lateness_trip{};  ///< A later one faults every axis in use (cycle overrun); zero: never.
  bool start_together = true;     ///< The first axis that is ready waits for the others.
  can::Duration start_timeout{std::chrono::seconds(5)};  ///< For so long.
  std::optional<Realtime> realtime{};
  BlackBox::Config black_box{};
  std::string control_socket;          ///< Empty: the path that default_socket() returns; "none": no socket.
  std::filesystem::path state_folder;  ///< Of what is saved at a clean stop; empty: nothing is saved.
};

can::Duration cycle_of(const CommonConfig& config);
/// `command_deadline` in force.
can::Duration command_deadline_of(const CommonConfig& config);

/// An axis that is not controlled. Its safe drive stands in a command frame that it shares with one that is.
struct RestingAxis {
  can::AxisWire wire;
  double safe_drive = 0.0;
};

struct Config : CommonConfig {
  std::vector<WiredAxisConfig> axes;
  std::vector<RestingAxis> resting{};
};

class Controller {
 public:
  using RecordHandler = std::function<void(const CycleRecord& record)>;

  /// Throws std::invalid_argument where the database lacks a message or a model is not valid.
  Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
             const can::Attach& attach, RecordHandler on_record);

  void start(bool clear_amplifier_faults = false);
  /// Requests of this link are answered, one in each cycle. Before start().
  void listen_to(RequestLink& link) { requests_ = &link; }
  /// Every axis ramps to its safe drive and switches off; stopped() when all have.
  void request_stop();
  bool stopped() const;
  /// A request asked for an end of the run. The caller who runs the controller ends it.
  bool asked_to_stop() const { return asked_to_stop_; }
  /// Another controller was here first: this one has sent nothing, and sends nothing.
  bool keeps_silent() const { return phase_ == Phase::silent; }
  /// Sends every amplifier the safe command at once. For the way out.
  void send_safe_commands();

  std::size_t axis_count() const { return axes_.size(); }
  const WiredAxis& wired_axis(std::size_t i) const { return *axes_[i]; }
  /// Before start(), to restore what an axis remembers.
  Axis& axis(std::size_t i) { return axes_[i]->axis; }
  const Axis& axis(std::size_t i) const { return axes_[i]->axis; }
  /// Of every message that the controller receives: samples, statuses, setpoints; of both nodes heartbeats,
  /// emergencies, SDO responses.
  std::vector<can::RejectedFrames> rejected() const;
  /// A line for each node to which other nodes have sent NMT commands or SDO requests, and for each one that
  /// does not keep its slot.
  std::vector<std::string> node_notes() const;
  const CycleCounters& counters() const { return counters_; }
  /// Since start. On the scheduler's thread, like everything here.
  const CycleTiming& timing() const { return timing_; }
  const can::Bus& bus() const { return *bus_; }

 private:
  /// off -> listening -> running; silent where another controller is heard while listening.
  enum class Phase : std::uint8_t { off, listening, running, silent };

  void make_axes(const Config& config, const can::Database& database);
  void add_handlers();
  void add_handlers_of(WiredAxis& wired);
  /// Where several axes share a node, each has a handler of its own.
  void add_handler(std::uint32_t id, bool extended, can::Bus::FrameHandler handler) {
    handlers_.emplace(std::pair(id, extended), std::move(handler));
  }
  void pass_on(const can::Frame& frame, can::Time heard) const;
  void tick();
  void close_cycle();
  void begin_cycle(can::Time now);
  void run_background_tasks();
  void answer_next_request();
  void on_samples(SampleFrame& samples, const can::Frame& frame, can::Time heard);
  void on_statuses(ReceivedFrame& statuses, const can::Frame& frame);
  void judge_slot(RemoteNode& node) const;
  void take_sample(WiredAxis& wired, const can::Frame& frame, can::Time heard);
  /// `heard`: when the sample arrived.
  void step(WiredAxis& wired, const can::SensorSample* sample, can::Time heard = {});
  bool is_awaited(const WiredAxis& wired) const;
  void answer(CommandFrame& commands);
  void end_waiting();
  AxisInput input_of(WiredAxis& wired, const can::SensorSample* sample) const;
  void record(WiredAxis& wired);
  void on_foreign_nmt(const can::Frame& frame);
  void trip_if_in_use(WiredAxis& wired, Cause cause);
  void on_another_controller(ForeignFrame::Kind kind, const can::Frame& frame);
  void keep_silent();
  void on_bus_state(can::BusState state);

  CommonConfig config_;
  can::Scheduler& scheduler_;
  RecordHandler on_record_;
  SharedFrames frames_;
  WiredAxes axes_;
  /// By identifier, and whether it is an extended one.
  std::multimap<std::pair<std::uint32_t, bool>, can::Bus::FrameHandler> handlers_;
  RequestLink* requests_ = nullptr;  ///< Null: there are none.
  bool asked_to_stop_ = false;
  BackgroundFrames background_;
  std::unique_ptr<can::Bus> bus_;
  std::unique_ptr<can::Timer> sync_timer_;
  std::unique_ptr<can::Timer> command_timer_;  ///< Null: no axes share a command frame.
  Phase phase_ = Phase::off;
  SyncClock clock_;
  TogetherStart together_;
  CycleCounters counters_;
  CycleTiming timing_;
};

}  // namespace hystcan::controller
