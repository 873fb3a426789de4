// The controller as a node on the bus: sends SYNC, receives samples and sends commands. The controller has
// one Axis for each axis of the stage.
//
//   SYNC(n) -> SensorSample(n) -> Axis::decide -> AmpCommand(n)
//
// The controller answers a sample immediately. If a sample has not arrived by the next SYNC, the controller
// steps the axis without it and counts the sample as missing. A command frame of several axes is sent when
// all of them have stepped, or at a deadline in the cycle: then the axes whose samples are missing are
// stepped without them. The frame does not wait for an axis whose samples have been missing for some cycles.
//
// All other frames (BackgroundFrames) and the answers to requests (carry_out) follow the commands of a cycle.
// SyncClock decides when a SYNC is due; TogetherStart decides when the axes begin to track.
//
// Before its first frame the controller listens for one heartbeat period. Four kinds of frame reveal another
// controller: a SYNC, a heartbeat with the controller's own node id, an axis status, and a command to one of
// its own amplifiers. Each of them faults every axis, and the log contains the frame. If the controller
// receives such a frame while it listens, it stays silent permanently; if it receives one later, it sends
// only safe commands from then on. If another node sends an NMT command or an SDO write to a node of an axis
// in use, this axis faults.
//
// Bus-off, or the loss of the interface, faults every driven axis in the next step. It also resets the state
// of all nodes: the controller must receive a node's heartbeat again before it arms the node's axis again.
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

/// The configuration of the controller as a whole.
struct CommonConfig {
  double rate_Hz = 1000.0;
  std::uint8_t node = 127;  ///< Node id of the controller, for its own heartbeat.
  can::Duration heartbeat_period{std::chrono::milliseconds(100)};
  /// A node without a heartbeat for this time counts as lost.
  can::Duration heartbeat_timeout{std::chrono::milliseconds(300)};
  /// Latest time after SYNC at which a command frame of several axes is sent; zero: nine tenths of the cycle.
  can::Duration command_deadline{};
  unsigned background_slots = 0;  ///< Number of slots for heartbeats and statuses (can::is_in_slot); 0: none.
  can::Duration lateness_warn{};  ///< A SYNC that is later than this is logged; zero: never.
  /// A SYNC that is later than this faults every axis in use (cycle overrun); zero: never.
  can::Duration lateness_trip{};
  bool start_together = true;  ///< The first axis that is ready waits for the others.
  /// Maximum time for which a ready axis waits for the others.
  can::Duration start_timeout{std::chrono::seconds(5)};
  std::optional<Realtime> realtime{};
  BlackBox::Config black_box{};
  /// Path of the control socket. Empty: the path that default_socket() returns; "none": no socket.
  std::string control_socket;
  std::filesystem::path state_folder;  ///< Folder for state saved at a clean stop; empty: nothing is saved.
};

can::Duration cycle_of(const CommonConfig& config);
/// Returns the command deadline that is in use: the configured one, or its default.
can::Duration command_deadline_of(const CommonConfig& config);

/// An axis that is not controlled. If it shares a command frame with a controlled axis, the frame contains
/// `safe_drive` for it.
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

  /// Throws std::invalid_argument if the database lacks a message or if a model is not valid.
  Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
             const can::Attach& attach, RecordHandler on_record);

  void start(bool clear_amplifier_faults = false);
  /// Sets the link whose requests the controller answers, one in each cycle. Called before start().
  void listen_to(RequestLink& link) { requests_ = &link; }
  /// Ramps every axis to its safe drive and switches it off. stopped() returns true when all axes are off.
  void request_stop();
  bool stopped() const;
  /// True if a request has asked for the end of the run. The program that runs the controller must then end
  /// the run.
  bool asked_to_stop() const { return asked_to_stop_; }
  /// True if another controller was already active on the bus. In this case, this controller has not sent a
  /// frame and will not send one.
  bool keeps_silent() const { return phase_ == Phase::silent; }
  /// Sends every amplifier the safe command immediately. Called before the program exits.
  void send_safe_commands();

  std::size_t axis_count() const { return axes_.size(); }
  const WiredAxis& wired_axis(std::size_t i) const { return *axes_[i]; }
  /// Returns an axis, for example to restore its saved state before start().
  Axis& axis(std::size_t i) { return axes_[i]->axis; }
  const Axis& axis(std::size_t i) const { return axes_[i]->axis; }
  /// Returns the rejected frames of every received message of each axis: samples, statuses, setpoints, and
  /// the heartbeats, emergencies and SDO responses of its sensor node and of its amplifier node.
  std::vector<can::RejectedFrames> rejected() const;
  /// Returns a line for each node to which other nodes have sent NMT commands or SDO requests, and for each
  /// node that sends outside its slot.
  std::vector<std::string> node_notes() const;
  const CycleCounters& counters() const { return counters_; }
  /// Returns statistics of the times of all cycles since start(). Called on the scheduler's thread, like all
  /// functions of this class.
  const CycleTiming& timing() const { return timing_; }
  const can::Bus& bus() const { return *bus_; }

 private:
  /// The phases are off -> listening -> running. In the phase silent the controller sends nothing, because it
  /// received frames of another controller while listening.
  enum class Phase : std::uint8_t { off, listening, running, silent };

  void make_axes(const Config& config, const can::Database& database);
  void add_handlers();
  void add_handlers_of(WiredAxis& wired);
  /// Adds a handler for the frames with this identifier. If several axes share a node, each has its own
  /// handler.
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
  /// Steps the axis. `sample`: null if it is missing. `heard`: time at which the sample arrived.
  void step(WiredAxis& wired, const can::SensorSample* sample, can::Time heard = {});
  bool is_awaited(const WiredAxis& wired) const;
  void answer(CommandFrame& commands);
  void end_waiting();
  AxisInput input_of(WiredAxis& wired, const can::SensorSample* sample, can::Time now) const;
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
  /// Handlers of received frames. Key: identifier, and true if the identifier is extended.
  std::multimap<std::pair<std::uint32_t, bool>, can::Bus::FrameHandler> handlers_;
  RequestLink* requests_ = nullptr;  ///< Carries requests from another thread; null if there is none.
  bool asked_to_stop_ = false;
  BackgroundFrames background_;
  std::unique_ptr<can::Bus> bus_;
  std::unique_ptr<can::Timer> sync_timer_;
  /// Timer for command_deadline; null if no axes share a command frame.
  std::unique_ptr<can::Timer> command_timer_;
  Phase phase_ = Phase::off;
  SyncClock clock_;
  TogetherStart together_;
  CycleCounters counters_;
  CycleTiming timing_;
};

}  // namespace hystcan::controller
