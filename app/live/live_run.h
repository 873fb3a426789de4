// A run that drives axes on a real bus, from the first SYNC to the final safe command.
#pragma once

#include <chrono>
#include <functional>

#include "app/live/live_loop.h"
#include "can/bus_health_log.h"
#include "controller/controller.h"

namespace hystcan::app {

/// SIGHUP has two meanings: the terminal was closed, or the user requests a reload of the configuration.
/// Returns true if the terminal was closed. This requires that, at the first call, the process had a
/// controlling terminal and did not ignore SIGHUP (nohup). The targets of its streams do not matter.
bool terminal_hung_up();

struct LiveRun {
  bool clear_faults = false;
  std::function<bool(double run_s)> is_done;  ///< called every 20 ms with the seconds since the start
  std::function<void()> before_stop{};        ///< called once, before the axes ramp down; may be empty
  std::function<void()> reload;               ///< called at SIGHUP; empty: SIGHUP ends the run
};

/// Runs the controller until is_done(), until a client sends `stop`, or until a signal. Then every axis ramps
/// to its safe drive and switches off. A second signal ends the ramp. The safe command is sent in every case,
/// also after an exception.
void run_live(LiveLoop& loop, controller::Controller& controller, can::BusHealthLog& bus_log,
              const LiveRun& run);

/// Limits how long a process may still wait for a disk or a reader after it has nothing more to do for its
/// actuators. Its destructor starts the time limit: the process then ends by itself, or at the limit with
/// exit status 1 and one line on standard error.
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
