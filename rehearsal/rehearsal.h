// A rehearsal: controller and twin run together in virtual time. Also measures the true tracking error.
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
// e is the tracking error at the time t. T_k is the time at which the SYNC frame of cycle k is complete on
// the bus: at this time the nodes sample the position and apply the command. t_k is the time of the same SYNC
// as the controller counts it, since its start. r is the reference as a function of the controller's time. x
// is the true position of the stage, with the couplings from other stages. The sensor (noise, delay, errors)
// does not affect e.
//
// The class TrueErrors only listens and reads values that the plants compute anyway, so it does not change
// the run.

class TrueErrors {
 public:
  /// Listens to the bus and to the twin's plants from now on. Bus, plants and controller must outlive this
  /// object, and this object must outlive the run of the twin. Errors in the first `settle_s` of each segment
  /// of the reference do not count, as in the statistics of the measured samples.
  TrueErrors(const twin::Config& config, twin::Twin& twin, const controller::Controller& controller,
             const can::Attach& attach, double settle_s);

  TrueErrors(const TrueErrors&) = delete;  // the plants have a pointer to this object
  TrueErrors& operator=(const TrueErrors&) = delete;

  /// Adds a cycle record of the controller. The caller adds all records, in the order of the cycles.
  void add(const controller::CycleRecord& record);

  /// Returns the statistics of the tracking error of the stage's true position, without sensor errors. One
  /// element per axis of the controller.
  std::vector<controller::TrackingStatistics> statistics() const;

 private:
  struct Cycle {
    can::Time begins;  ///< time at which the cycle's SYNC frame was complete on the bus
    double time_s;     ///< time of the cycle's SYNC frame on the controller's clock, s since its start
  };
  struct Point {
    can::Time time;
    double own_um;  ///< position of the stage without the couplings from other stages
  };
  struct Axis {
    can::Duration substep;
    std::vector<model::Coupling> couplings;
    double start_um;
    /// Positions of the stage that the statistics do not contain yet, and the last position before them.
    /// coupled_um() interpolates between these positions.
    std::deque<Point> points;
    controller::TrackingStatistics statistics;
  };

  void take(Axis& axis, can::Time time, double own_um);
  bool is_known_until(can::Time time) const;
  void judge(std::size_t index, const Cycle& cycle, can::Time end);
  double coupled_um(const Axis& axis, can::Time time) const;

  const controller::Controller& controller_;
  std::vector<std::unique_ptr<Axis>> axes_;  ///< the axes of the twin
  std::vector<std::size_t> stages_;          ///< for each axis of the controller, its index in axes_
  std::unique_ptr<can::Bus> bus_;
  std::optional<can::Time> last_sync_;
  std::deque<Cycle> cycles_;
};

// Controller and twin in one process, on one simulated bus in virtual time, with the same nodes as in the two
// separate programs. The controller transmits its frames in the order of sending, like a SocketCAN interface.
// Each node of the twin transmits its frames by priority, like the transmit buffers of a microcontroller.

struct Setup {
  controller::Config controller;
  twin::Config twin;
  can::Database database;
  can::BitRates rates{};
};

/// The controller, the twin and the bus between them. Virtual time starts at zero and advances only in
/// run_for().
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

/// The result of run_once(): every axis ran once through its reference.
struct Outcome {
  std::vector<controller::AxisOutcome> axes;
  /// Statistics of the tracking error of the stage's true position, one element for each axis of the
  /// controller. They contain the errors at the samples and between them (see class TrueErrors).
  std::vector<controller::TrackingStatistics> true_errors;
  double virtual_s = 0.0;
  double bus_load = 0.0;  ///< share of the time in which the bus is busy, 0 to 1
  controller::CycleCounters counters;
};

/// Starts controller and twin at power-on and runs until every axis has finished its reference. Ends early if
/// an axis faults or does not finish in time. Errors in the first `settle_s` of each segment do not count.
/// `on_truth` receives the true state of the twin's stages at every sample; it may be empty.
Outcome run_once(const Setup& setup, double settle_s, const controller::Controller::RecordHandler& on_record,
                 const twin::TruthHandler& on_truth = {});

/// Returns the setup with the control structure `structure` on every axis, to compare structures. Disables
/// the following-error trip: its limit is tuned for the configured structure, and would end the run of a
/// structure with larger errors.
Setup with_structure(Setup setup, controller::Structure structure);

}  // namespace hystcan::rehearsal
