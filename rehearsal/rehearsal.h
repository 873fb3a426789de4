// Controller and twin, the very nodes of the two processes, on one simulated bus in virtual time. The
// controller's frames leave it in the order in which they are sent, as from a SocketCAN interface; those of
// the twin's nodes by priority, as from a microcontroller's transmit buffers.
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
  /// The twin's power is cut: every node of it is gone from the bus.
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

/// One pass of every axis's reference.
struct Outcome {
  std::vector<controller::AxisOutcome> axes;
  double virtual_s = 0.0;
  double bus_load = 0.0;  ///< 0..1
  controller::CycleCounters counters;
};

/// One pass of every axis's reference, from power-on; ends early where an axis faults. Errors of the first
/// `settle_s` of each segment are not counted.
/// `on_truth`, if there is one, is told what the twin's stages really did.
Outcome run_once(const Setup& setup, double settle_s, const controller::Controller::RecordHandler& on_record,
                 const twin::TruthHandler& on_truth = {});

/// The same setup with every axis under `structure`, for comparison: the following-error trip, tuned for the
/// structure in use, is lifted, so that a poor one can show how poor it is.
Setup with_structure(Setup setup, controller::Structure structure);

}  // namespace hystcan::rehearsal
