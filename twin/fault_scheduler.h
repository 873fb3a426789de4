// Begins and ends the faults of a twin: by the configured schedule, at random from a seed, and on request at
// run time. All times are times of can::Scheduler, real or virtual. The same seed gives the same faults.
//
// If a fault begins while it is already active, it continues with the new value and the new end. A fault
// parameter_drift changes the factor on the stage's travel linearly from its present value to 1 + value. The
// factor stays there after the end of the fault. remove() sets the factor back to 1, and a second drift with
// the value 0 moves it back to 1.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "twin/axis.h"
#include "twin/config.h"

namespace hystcan::twin {

class FaultScheduler {
 public:
  using EventHandler = std::function<void(const FaultSpec&, bool begins, can::Time)>;
  struct Active {
    FaultSpec spec;
    can::Time began{};
    can::Time ends{};
    double gain_before = 1.0;  ///< factor on the stage's travel when the fault began, for parameter_drift
  };

  /// The axes must outlive this object. Throws std::invalid_argument if an axis can't have a scheduled fault.
  FaultScheduler(can::Scheduler& scheduler, std::vector<FaultTarget> axes,
                 const std::vector<FaultSpec>& scheduled, const std::optional<RandomFaults>& random);

  /// Calls `handler` at every begin and end of a fault.
  void on_event(EventHandler handler) { on_event_ = std::move(handler); }
  /// Starts the schedule and the random faults. The times of the scheduled faults count from `start`. A fault
  /// that is already due begins now.
  void start(can::Time start);
  /// Ends every fault; no further fault begins.
  void stop();

  /// Begins a fault now. Throws std::invalid_argument if the axis does not exist or can't have this fault.
  void inject(const FaultSpec& spec);
  /// Ends the active faults of this kind and this axis. For parameter_drift, also sets the factor on the
  /// stage's travel back to 1. Without `kind` all kinds end; an empty `axis` means all axes. Returns the
  /// number of ended faults.
  std::size_t remove(std::optional<Fault> kind = {}, std::string_view axis = {});
  const std::vector<Active>& active() const { return active_; }

 private:
  struct Planned {
    FaultSpec spec;
    can::Time begins{};
  };

  std::size_t axis_of(const FaultSpec& spec) const;
  bool same_place(const FaultSpec& a, const FaultSpec& b) const;
  void list_random_faults();
  void plan_next_random();
  void begin_random_fault();
  double uniform() { return static_cast<double>(random_source_() >> 11U) * 0x1p-53; }
  void wake();
  void begin_what_is_due(can::Time now);
  void end_what_is_due(can::Time now);
  void arm();
  void begin(const FaultSpec& spec);
  void apply(const FaultSpec& spec, bool begins);
  void drift(const Active& active, can::Time now);
  void disturb(std::size_t axis, double Disturbance::*what, double value);

  can::Scheduler& scheduler_;
  std::vector<FaultTarget> axes_;
  std::vector<Disturbance> disturbances_;  ///< present disturbance of each axis's plant
  std::vector<FaultSpec> scheduled_;
  std::optional<RandomFaults> random_;
  std::vector<FaultSpec> random_faults_;  ///< faults from which a random fault is drawn, with default values
  std::mt19937_64 random_source_;
  can::Time next_random_ = can::Time::max();
  std::vector<Planned> planned_;
  std::vector<Active> active_;
  EventHandler on_event_;
  std::unique_ptr<can::Timer> timer_;
};

}  // namespace hystcan::twin
