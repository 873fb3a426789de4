// Begins and ends faults: by the configured schedule, at random from a seed, and on request at run time. All
// times are the scheduler's, real or virtual; the same seed gives the same faults.
//
// If an active fault begins again, it continues with the new value and the new end. A drift changes the
// travel linearly from its present value to 1 + value, and the travel stays there after the end. Another
// drift with the value 0, or remove(), reverses it.
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
    double gain_before = 1.0;  ///< gain at the start of a drift
  };

  /// The axes must outlive this object. Throws std::invalid_argument if a scheduled fault is not possible.
  FaultScheduler(can::Scheduler& scheduler, std::vector<FaultTarget> axes,
                 const std::vector<FaultSpec>& scheduled, const std::optional<RandomFaults>& random);

  /// Calls `handler` at every begin and end of a fault.
  void on_event(EventHandler handler) { on_event_ = std::move(handler); }
  /// Schedule times count from `start`; faults that are already due begin now.
  void start(can::Time start);
  /// Ends every fault; no further fault begins.
  void stop();

  /// Begins a fault now. Throws std::invalid_argument if it is not possible.
  void inject(const FaultSpec& spec);
  /// Ends the active faults, limited to this kind and this axis if they are given, and reverses drifts.
  /// Returns the number of faults that were active.
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
  std::vector<Disturbance> disturbances_;  ///< one for each axis's plant
  std::vector<FaultSpec> scheduled_;
  std::optional<RandomFaults> random_;
  std::vector<FaultSpec> random_faults_;  ///< candidates for random faults, with their default values
  std::mt19937_64 random_source_;
  can::Time next_random_ = can::Time::max();
  std::vector<Planned> planned_;
  std::vector<Active> active_;
  EventHandler on_event_;
  std::unique_ptr<can::Timer> timer_;
};

}  // namespace hystcan::twin
