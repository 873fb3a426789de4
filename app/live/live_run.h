// Runs a controller on a real bus, from the first SYNC to the final safe command.
#pragma once

#include <chrono>
#include <functional>

#include "app/live/live_loop.h"
#include "can/bus_health_log.h"
#include "controller/controller.h"

namespace hystcan::app {

/// SIGHUP can mean that the terminal was closed, or that the user requests a reload of the configuration.
/// Returns true if the terminal was closed. It can return true only if, at its first call, the process had a
/// controlling terminal and did not ignore SIGHUP (nohup). Redirected standard streams make no difference.
bool terminal_hung_up();

struct LiveRun {
  bool clear_faults = false;
  std::function<bool(double run_s)> is_done;  ///< returns true if the run must end; called every 20 ms with
                                              ///< the time since the start
  std::function<void()> before_stop{};        ///< called once when the run must end, before the axes ramp
                                              ///< down; may be empty
  std::function<void()> reload;               ///< called at SIGHUP to reload the configuration; if empty,
                                              ///< SIGHUP ends the run
};

/// Runs the controller until `run.is_done` returns true, a client sends `stop`, or a signal arrives. Then
/// every axis ramps to its safe drive and switches off. A second signal ends the ramp at once. At the end,
/// even after an exception, the safe command is sent. If another controller is already active on the bus, the
/// run ends and sends nothing at all.
void run_live(LiveLoop& loop, controller::Controller& controller, can::BusHealthLog& bus_log,
              const LiveRun& run);

/// Limits how long a process may still write to files and streams after its actuators are safe. The
/// destructor starts the time limit. A process that has not ended by then is ended with exit status 1 and one
/// line on standard error.
class ExitLimit {
 public:
  explicit ExitLimit(std::chrono::milliseconds limit) : limit_(limit) {}
  ~ExitLimit();
  ExitLimit(const ExitLimit&) = delete;
  ExitLimit& operator=(const ExitLimit&) = delete;

 private:
  std::chrono::milliseconds limit_;
};

}  // namespace hystcan::app
