// What the commands that drive axes on a real bus share: from the first SYNC to the safe command on the way
// out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/live/live_loop.h"
#include "app/report/report.h"
#include "can/bus_health_log.h"
#include "config/schema/config.h"
#include "controller/controller.h"

namespace hystcan::app {

/// Says on the log what becomes of each axis.
class StateLog {
 public:
  explicit StateLog(const config::Config& config);
  void add(const controller::CycleRecord& record);
  /// What the nodes said by emergency, and why one could not be set up: the first hundred.
  const std::vector<std::string>& events() const { return events_; }

 private:
  void add_event(const controller::CycleRecord& record);

  std::vector<std::string> names_;
  std::vector<std::string> nodes_;
  std::vector<controller::AxisState> states_;
  std::vector<std::string> events_;
};

/// Whether the interface is fit for a node that sends, and a line on the log that says what it is set to;
/// warnings where that is doubtful. Throws InterfaceError where it is not.
void look_at_interface(const config::Config& config, const std::string& interface);

/// [controller.realtime] for this thread, a warning for each thing refused. Threads that are there by now
/// keep what they had.
void become_realtime(const config::Config& config);

/// Puts the lines of a can::BusHealthLog on ours.
can::BusHealthLog::Sink bus_log_sink();

BusClosing closing_of(const controller::Controller& controller, const std::vector<std::string>& events);

/// SIGHUP is two things: the terminal is gone, or somebody asks for the configuration to be read again. True
/// of the first, where this process had a controlling terminal and did not ignore SIGHUP (nohup) when it was
/// called first; where its streams lead does not matter.
bool terminal_hung_up();

struct LiveRun {
  bool clear_faults = false;
  std::function<bool(double run_s)> is_done;  ///< asked every 20 ms, told the seconds since start
  std::function<void()> reload;               ///< at SIGHUP; empty: SIGHUP ends the run
};

/// Runs the controller until it is done, asked to stop, or until a signal; then every axis ramps to its safe
/// drive and switches off. A second signal does not wait for the ramp. The safe command goes out on every way
/// out, an exception's too.
void run_live(LiveLoop& loop, controller::Controller& controller, can::BusHealthLog& bus_log,
              const LiveRun& run);

}  // namespace hystcan::app
