// A rehearsal in virtual time, and the measurement of its true tracking error.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/sim/sim_bus.h"
#include "controller/control/statistics.h"
#include "controller/controller.h"
#include "twin/twin.h"

namespace hystcan::rehearsal {

// The tracking error between the samples: the difference between the reference and the twin's true position,
// at every sub-step of the plant.
//
//   e(t) = r(t_k + (t - T_k)) - x(t),   T_k <= t < T_{k+1}
//
// T_k is the time at which the SYNC of cycle k is complete on the bus, when the nodes sample and apply. t_k
// is the same SYNC in the controller's time. r is the reference as a function of time; x is the position with
// its couplings. The sensor (noise, delay, errors) does not affect e.
//
// The class only listens and reads values that the plants compute anyway, so it does not change the run.

class TrueErrors {
 public:
  /// Listens to the bus and to the plants from now on; both must outlive the object. Errors in the first
  /// `settle_s` of each segment do not count, as in the statistics of the samples.
  TrueErrors(const twin::Config& config, twin::Twin& twin, const controller::Controller& controller,
             const can::Attach& attach, double settle_s);

  TrueErrors(const TrueErrors&) = delete;  // the plants call this object
  TrueErrors& operator=(const TrueErrors&) = delete;

  /// Adds the records of the controller, in their order.
  void add(const controller::CycleRecord& record);

  /// Returns the statistics of each axis of the controller.
  std::vector<controller::TrackingStatistics> statistics() const;

 private:
  struct Cycle {
    can::Time begins;  ///< T_k
    double time_s;     ///< t_k
  };
  struct Point {
    can::Time time;
    double own_um;  ///< position of the stage without couplings
  };
  struct Axis {
    can::Duration substep;
    std::vector<model::Coupling> couplings;
    double start_um;
    std::deque<Point> points;  ///< not judged yet, and the last judged one
    controller::TrackingStatistics statistics;
  };

  void take(Axis& axis, can::Time time, double own_um);
  bool is_known_until(can::Time time) const;
  void judge(std::size_t index, const Cycle& cycle, can::Time end);
  double coupled_um(const Axis& axis, can::Time time) const;

  const controller::Controller& controller_;
  std::vector<std::unique_ptr<Axis>> axes_;  ///< axes of the twin
  std::vector<std::size_t> stages_;          ///< index in axes_ of each axis of the controller
  std::unique_ptr<can::Bus> bus_;
  std::optional<can::Time> last_sync_;
  std::deque<Cycle> cycles_;
};

// Controller and twin, with the same nodes as in the two processes, on one simulated bus in virtual time. The
// controller transmits its frames in the order of sending, like a SocketCAN interface. The twin's nodes
// transmit by priority, like the transmit buffers of a microcontroller.

struct Setup {
  controller::Config controller;
  twin::Config twin;
  can::Database database;
  can::BitRates rates{};
};

/// The whole loop. Virtual time starts at zero and advances only in run_for().
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
  double time_s() const { return can::seconds(clock_.now().time_since_epoch()); }
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
  /// Per axis: error of the twin's true position at every sub-step, also between the samples (class
  /// TrueErrors).
  std::vector<controller::TrackingStatistics> true_errors;
  double virtual_s = 0.0;
  double bus_load = 0.0;  ///< 0..1
  controller::CycleCounters counters;
};

/// Runs one pass of every axis's reference, starting at power-on; ends early if an axis faults. Errors in the
/// first `settle_s` of each segment do not count. `on_truth` may be empty; it receives the true state of the
/// twin's stages.
Outcome run_once(const Setup& setup, double settle_s, const controller::Controller::RecordHandler& on_record,
                 const twin::TruthHandler& on_truth = {});

/// Returns the same setup with `structure` on every axis, for comparison. Disables the following-error trip,
/// which is tuned for the configured structure, so that a poor structure can show its errors.
Setup with_structure(Setup setup, controller::Structure structure);

}  // namespace hystcan::rehearsal
