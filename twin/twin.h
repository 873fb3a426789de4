// The simulation twin: for each axis a simulated stage with its two bus nodes, amplifier and sensor. Axes
// with the same node number share the node.
//
// The twin communicates only over the bus. Each node has its own bus connection, like a real node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/scheduler.h"
#include "model/coupling.h"
#include "node/station.h"
#include "twin/fault_scheduler.h"

namespace hystcan::twin {

// struct Truth has the true state of a simulated stage, the commanded value and the measured value. A
// comparison of the three shows whether a sign or a scale is wrong.

/// The true state of one axis at the time of a sample.
struct Truth {
  can::Time time;  ///< time of the sample on the twin's clock: CLOCK_MONOTONIC, or virtual time
  std::size_t axis = 0;
  std::uint8_t sync_counter = 0;  ///< SYNC counter in the sensor's sample
  double setpoint = 0.0;          ///< last commanded value, drive units
  double drive = 0.0;             ///< input of the actuator, noise included, drive units
  double hysteresis_um = 0.0;     ///< output of the actuator's hysteresis
  double position_um = 0.0;       ///< true position of the stage
  double measured_um = 0.0;       ///< position that the sensor measured, before faults change the frame
};

using TruthHandler = std::function<void(const Truth&)>;

class Twin {
 public:
  /// Throws std::invalid_argument if the database lacks a message of an axis, or if a parameter is out of
  /// range.
  Twin(const Config& config, const can::Database& database, can::Scheduler& scheduler,
       const can::Attach& attach);

  Twin(const Twin&) = delete;
  Twin& operator=(const Twin&) = delete;

  /// Starts all nodes (see node::Station::start()) and the schedule of the faults.
  void start();
  /// Ends all faults and switches every amplifier off; each output ends at its safe value.
  void shut_down();

  const node::Station& station() const { return station_; }
  const Axes& axes() const { return axes_; }
  /// Calls `handler` with the true state at every sample of every axis. The call does not delay the sample.
  void on_truth(const TruthHandler& handler);
  FaultScheduler& faults() { return *faults_; }
  const FaultScheduler& faults() const { return *faults_; }

 private:
  template <class Made, class... Arguments>
  Connected<Made> connect(const can::Attach& attach, const FaultyConnection::Config& config,
                          const Arguments&... arguments);

  can::Scheduler& scheduler_;
  node::Station station_;
  Axes axes_;
  std::unique_ptr<FaultScheduler> faults_;
};

}  // namespace hystcan::twin
