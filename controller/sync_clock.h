// The times of the cycles. A cycle begins with its SYNC, and two SYNCs are at least half a cycle apart. If a
// SYNC is late by more than half a cycle, its lateness also delays the deadlines of the later SYNCs and the
// references of all axes:
//
//   reference time = time - waited,    waited = sum of the latenesses of such SYNCs
//
// From SYNC to SYNC, the reference time advances by half a cycle to one and a half cycles. If the second SYNC
// is late by more than half a cycle, the reference time advances by at most one cycle.
#pragma once

#include <cstdint>

#include "can/scheduler.h"

namespace hystcan::controller {

/// One cycle, starting with its SYNC.
struct Cycle {
  std::uint8_t sync_counter = 0;
  can::Time sync_sent{};
  can::Duration lateness{};     ///< Delay of the SYNC after its deadline.
  can::Duration sync_period{};  ///< Time since the previous SYNC; zero for the first SYNC.
  double dt_s = 0.0;            ///< Time since the previous SYNC; for the first SYNC, since start().
};

class SyncClock {
 public:
  explicit SyncClock(can::Duration period) : period_(period) {}

  void start(can::Time now, can::Duration to_first_sync);
  /// Begins the next cycle. Called when its SYNC is sent.
  void begin_cycle(can::Time now);
  /// Makes time_s() return the time `now`. Called before the last step of the axes, which has no SYNC.
  void end(can::Time now) { cycle_.sync_sent = now; }

  const Cycle& cycle() const { return cycle_; }
  can::Time deadline() const { return deadline_; }  ///< Deadline of the next SYNC.
  can::Duration period() const { return period_; }
  can::Duration waited() const { return waited_; }
  std::uint64_t missed_cycles() const {
    return static_cast<std::uint64_t>((waited_ + period_ / 2) / period_);
  }
  double since_start_s(can::Time time) const { return can::seconds(time - started_); }
  double time_s() const { return since_start_s(cycle_.sync_sent); }  ///< Time of this cycle's SYNC.

 private:
  can::Duration period_;
  can::Time started_{};
  can::Time deadline_{};
  can::Duration waited_{};
  Cycle cycle_;
};

}  // namespace hystcan::controller
