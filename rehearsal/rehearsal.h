// Controller and twin, with the same nodes as in the two processes, on one simulated bus in virtual time. The
// controller transmits its frames in the order of sending, as a SocketCAN interface does; the twin's nodes
// transmit by priority, as a microcontroller's transmit buffers do.
#pragma once

#include <cstdint>
#include <vector>

#include "can/dbc/database.h"
#include "can/sim/sim_bus.h"
#include "controller/control/statistics.h"
#include "controller/controller.h"
#include "twin/twin.h"

namespace hystcan::rehearsal {

struct Setup {
  controller::Config controller;
  twin::Config twin;
  can::Database database;
  std::uint32_t bitrate_bit_per_s = 1'000'000;
};

/// The whole loop. Virtual time starts at zero and moves only in run_for().
class Rehearsal {
 public:
  Rehearsal(const Setup& setup, controller::Controller::RecordHandler on_record);

  void start();
  void run_for(can::Duration duration);

  controller::Controller& controller() { return controller_; }
  twin::Twin& twin() { return *twin_; }
  /// Cuts the twin's power: all its nodes leave the bus.
  void kill_twin() { twin_.reset(); }
  can::SimBus& bus() { return bus_; }
  can::VirtualClock& clock() { return clock_; }
  const can::Attach& attach() const { return attach_; }

 private:
  can::VirtualClock clock_;
  can::SimBus bus_;
  can::Attach attach_;
  std::unique_ptr<twin::Twin> twin_;
  controller::Controller controller_;
};

/// Result of one pass of every axis's reference.
struct Outcome {
  std::vector<controller::AxisOutcome> axes;
  /// Per axis: the error of the twin's true position at every sub-step, also between the samples
  /// (rehearsal/true_error.h).
  std::vector<controller::TrackingStatistics> true_errors;
  double virtual_s = 0.0;
  double bus_load = 0.0;  ///< 0..1
  controller::CycleCounters counters;
};

/// Runs one pass of every axis's reference from power-on; ends early where an axis faults. Errors in the
/// first `settle_s` of each segment do not count. `on_truth` may be empty; it receives the true state of the
/// twin's stages.
Outcome run_once(const Setup& setup, double settle_s, const controller::Controller::RecordHandler& on_record,
                 const twin::TruthHandler& on_truth = {});

/// The same setup with `structure` on every axis, for comparison. The following-error trip is tuned for the
/// configured structure, so it is switched off: a poor structure can show its errors.
Setup with_structure(Setup setup, controller::Structure structure);

}  // namespace hystcan::rehearsal
