// The controller as a node on the bus: makes the SYNC, hears samples, sends commands; one Axis for each axis.
//
//   SYNC(n) -> SensorSample(n) -> Axis::step -> AmpCommand(n)
//
// A sample is answered as it arrives. One that has not come by the next SYNC is bridged then, and counted.
// The own heartbeat, and of axis statuses, NMT and SDO one frame a cycle, follow its commands. Before its
// first frame it listens for one heartbeat period. Somebody else's SYNC, heartbeat of its own node id, axis
// status or command to its amplifiers faults every axis: heard while it listens, it stays silent for good;
// later, its commands are safe from there on. Bus-off, or the loss of the interface, faults every driven axis
// with the next step, and what was known of the nodes is forgotten: whoever is to be armed again must be
// heard again first.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "controller/black_box.h"
#include "controller/control/axis.h"
#include "controller/cycle_record.h"
#include "controller/own_frames.h"
#include "controller/realtime.h"
#include "controller/remote_node.h"
#include "controller/request_link.h"
#include "controller/timing.h"

namespace hystcan::controller {

struct WiredAxisConfig {
  can::AxisWire wire;
  AxisConfig axis;
  bool live_setpoint = false;  ///< obeys Setpoint frames, from whomever
};

struct Config {
  double rate_Hz = 1000.0;
  std::uint8_t node = 127;  ///< of the controller's own heartbeat
  can::Duration heartbeat_period{std::chrono::milliseconds(100)};
  can::Duration heartbeat_timeout{std::chrono::milliseconds(300)};  ///< of the other nodes
  can::Duration wake_up_warn{};  ///< a SYNC this late is told on the log; zero: never
  can::Duration wake_up_trip{};  ///< one this late faults every axis in use (cycle overrun); zero: never
  std::optional<Realtime> realtime{};
  BlackBox::Config black_box{};
  std::string control_socket;          ///< empty: where default_socket() says; "none": there is none
  std::filesystem::path state_folder;  ///< of what is saved at a clean stop; empty: nothing is
  std::vector<WiredAxisConfig> axes;
};

class Controller {
 public:
  using RecordHandler = std::function<void(const CycleRecord& record)>;

  /// Throws std::invalid_argument where the database lacks a message or a model is not valid.
  Controller(const Config& config, const can::Database& database, can::Scheduler& scheduler,
             const can::Attach& attach, RecordHandler on_record);

  void start(bool clear_amplifier_faults = false);
  /// From here on what is asked there is answered, one request in each cycle. Before start().
  void listen_to(RequestLink& requests) { requests_ = &requests; }
  /// Every axis ramps to its safe drive and switches off; stopped() when all have.
  void request_stop();
  bool stopped() const;
  /// By a request: whoever runs it is to end it.
  bool asked_to_stop() const { return asked_to_stop_; }
  /// Another controller was here first: nothing has been sent, nor will be.
  bool keeps_silent() const { return phase_ == Phase::silent; }
  /// Sends every amplifier the safe command at once. For the way out.
  void send_safe_commands();

  std::size_t axis_count() const { return axes_.size(); }
  /// Before start(): what an axis is to restore.
  Axis& axis(std::size_t i) { return axes_[i]->axis; }
  const Axis& axis(std::size_t i) const { return axes_[i]->axis; }
  const can::E2eChecker& sample_checker(std::size_t i) const { return axes_[i]->decode_sample.checker(); }
  /// Empty: this axis takes none.
  std::optional<SetpointCounters> live_setpoints(std::size_t i) const;
  /// Of every message that the controller hears: samples, statuses, setpoints; of both nodes heartbeats,
  /// emergencies, SDO responses.
  std::vector<can::RejectedFrames> rejected() const;
  const CycleCounters& counters() const { return counters_; }
  /// Since start. On the scheduler's thread, as everything here.
  const CycleTiming& timing() const { return timing_; }
  const can::Bus& bus() const { return *bus_; }

 private:
  struct WiredAxis {
    WiredAxis(const WiredAxisConfig& config, const Config& common, const can::Database& database);
    can::AxisWire wire;
    Axis axis;
    can::Decoder<can::SensorSample> decode_sample;
    std::optional<can::Decoder<can::AmpStatus>> decode_status;  ///< empty: the amplifier tells nothing
    can::Encoder<can::AmpCommand> encode_command;
    bool samples_name_their_sync;     ///< else a sample counts for the cycle it arrives in
    bool flags_tell_fault;            ///< the state alone does not
    can::E2eChecker foreign_command;  ///< of commands to this amplifier that are not ours
    StatusSender status_sender;
    std::optional<SetpointReceiver> setpoint_receiver;  ///< empty: it obeys no stranger
    RemoteNode sensor;
    RemoteNode amplifier;
    can::AmpStatus status;
    bool amplifier_moves = false;  ///< enabled, or on its way down: `status` does not tell where it is
    unsigned boot_ups_seen = 0;
    bool late_sample = false;   ///< since the last step
    bool bus_off_seen = false;  ///< since the last step, however short it was
    bool answered = true;       ///< this cycle's step has been taken
  };

  void tick();
  void note_wake_up(can::Time now);
  void close_cycle();
  void run_background_tasks();
  void answer_a_request();
  std::string_view obey(Request& request);
  std::size_t node_count() const { return 2 * axes_.size(); }
  RemoteNode& node_at(std::size_t place);
  bool tell_of_an_axis();
  bool set_up_a_node();
  bool wake_a_node();
  bool wake(const RemoteNode& node);
  void handle(const can::Frame& frame);
  void hear_another();
  void keep_silent();
  void on_bus_state(can::BusState state);
  void on_sample(std::size_t index, const can::Frame& frame);
  void on_status(std::size_t index, const can::Frame& frame);
  static bool tells_of_a_move(const WiredAxis& wired, const can::AmpStatus& status);
  void on_sensor_heartbeat(std::size_t index, const can::Frame& frame);
  void on_amplifier_heartbeat(std::size_t index, const can::Frame& frame);
  void on_own_heartbeat(std::size_t, const can::Frame& frame);
  void on_foreign_sync(std::size_t, const can::Frame& frame);
  void on_foreign_command(std::size_t index, const can::Frame& frame);
  void on_foreign_axis_status(std::size_t index, const can::Frame& frame);
  void on_setpoint(std::size_t index, const can::Frame& frame);
  template <RemoteNode WiredAxis::*node>
  void on_emergency(std::size_t index, const can::Frame& frame) {
    (axes_[index].get()->*node).hear_emergency(frame);
  }
  template <RemoteNode WiredAxis::*node>
  void on_sdo(std::size_t index, const can::Frame& frame) {
    (axes_[index].get()->*node).hear_sdo(frame);
  }
  template <RemoteNode WiredAxis::*node>
  void add_node_routes(std::size_t index, void (Controller::*on_heartbeat)(std::size_t, const can::Frame&));
  void lay_route(std::uint32_t id, bool extended, void (Controller::*handler)(std::size_t, const can::Frame&),
                 std::size_t index);
  void step(std::size_t index, const can::SensorSample* sample);
  void send_command(WiredAxis& wired, const AxisCommand& command);
  double coupled_um(Axis& axis, const AxisInput& input) const;
  NodeHealth health(WiredAxis& wired) const;

  /// What to do with an identifier: filled and sorted once, looked up per frame.
  struct Route {
    std::uint32_t id = 0;
    bool extended = false;
    void (Controller::*handler)(std::size_t index, const can::Frame& frame) = nullptr;
    std::size_t index = 0;

    auto key() const { return std::pair(id, extended); }
  };
  void lay_routes();
  const Route* find_route(const can::Frame& frame) const;

  Config config_;
  can::Scheduler& scheduler_;
  RecordHandler on_record_;
  std::vector<std::unique_ptr<WiredAxis>> axes_;
  std::unique_ptr<can::Bus> bus_;
  std::vector<Route> routes_;
  RequestLink* requests_ = nullptr;
  bool asked_to_stop_ = false;
  std::unique_ptr<can::Timer> sync_timer_;
  can::Duration period_;
  can::Time started_{};
  can::Time deadline_{};
  can::Time sync_sent_{};
  can::Duration sync_late_{};    ///< after its deadline
  can::Duration sync_period_{};  ///< from the SYNC before; zero at the first
  can::Time heard_{};            ///< the frame being handled
  can::Time next_heartbeat_{};
  double dt_s_ = 0.0;
  std::uint8_t sync_counter_ = 0;
  bool begin_tracking_ = false;
  bool house_kept_ = true;  ///< in this cycle
  std::size_t next_to_tell_of_ = 0;
  bool told_last_cycle_ = false;
  std::size_t next_to_set_up_ = 0;
  std::size_t next_to_wake_ = 0;  ///< all nodes: none is left to be woken before the next heartbeat
  enum class Phase : std::uint8_t { off, listening, running, silent };
  Phase phase_ = Phase::off;
  CycleCounters counters_;
  CycleTiming timing_;
};

}  // namespace hystcan::controller
