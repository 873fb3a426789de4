// The tracking error between the samples: the twin's true position against the reference, at every sub-step of the
// plant.
//
//   e(t) = r(t_k + (t - T_k)) - x(t),   T_k <= t < T_{k+1}
//
// T_k is the time at which the SYNC of cycle k is complete on the bus: there the nodes sample and apply. t_k is the same
// SYNC in the controller's time. r is the reference as a function of time; x is the position with its couplings. The
// sensor (noise, delay, errors) has no part in it.
//
// It listens and reads what the plants compute anyway, so it changes no bit of the run.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "controller/control/statistics.h"
#include "controller/controller.h"
#include "twin/twin.h"

namespace hystcan::rehearsal {

class TrueErrors {
 public:
  /// Listens to the bus and to the plants from now on; both must outlive this. Errors in the first `settle_s` of each
  /// segment do not count, as in the statistics of the samples.
  TrueErrors(const twin::Config& config, twin::Twin& twin, const controller::Controller& controller,
             const can::Attach& attach, double settle_s);

  TrueErrors(const TrueErrors&) = delete;  // the plants call it
  TrueErrors& operator=(const TrueErrors&) = delete;

  /// Takes the records of the controller, in their order.
  void add(const controller::CycleRecord& record);

  /// Per axis of the controller.
  std::vector<controller::TrackingStatistics> statistics() const;

 private:
  struct Cycle {
    can::Time begins;  ///< T_k
    double time_s;     ///< t_k
  };
  struct Point {
    can::Time time;
    double own_um;  ///< without couplings
  };
  struct Axis {
    can::Duration substep;
    std::vector<model::Coupling> couplings;
    double start_um;
    std::deque<Point> points;  ///< what is not judged yet, and the last one before
    controller::TrackingStatistics statistics;
  };

  void take(Axis& axis, can::Time time, double own_um);
  bool is_known_until(can::Time time) const;
  void judge(std::size_t index, const Cycle& cycle, can::Time end);
  double coupled_um(const Axis& axis, can::Time time) const;

  const controller::Controller& controller_;
  std::vector<std::unique_ptr<Axis>> axes_;  ///< of the twin
  std::vector<std::size_t> stages_;          ///< index in axes_ of each axis of the controller
  std::unique_ptr<can::Bus> bus_;
  std::optional<can::Time> last_sync_;
  std::deque<Cycle> cycles_;
};

}  // namespace hystcan::rehearsal
