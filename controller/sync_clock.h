// The times of the cycles. Two SYNCs are at least half a cycle apart. A SYNC that is late by more than half a
// cycle delays the deadlines of the later ones and the references of all axes by its lateness:
//
//   reference time = time - waited,    waited = sum of these latenesses
//
// From SYNC to SYNC the reference time advances by half a cycle to one and a half, and by at most one where
// it waits.
#pragma once

#include <cstdint>

#include "can/scheduler.h"

namespace hystcan::controller {

/// One cycle, from its SYNC on.
struct Cycle {
  std::uint8_t sync_counter = 0;
  can::Time sync_sent{};
  can::Duration lateness{};     ///< Of the SYNC, after its deadline.
  can::Duration sync_period{};  ///< From the SYNC before; zero at the first.
  double dt_s = 0.0;            ///< From the SYNC before, or from start().
};

class SyncClock {
 public:
  explicit SyncClock(can::Duration period) : period_(period) {}

  void start(can::Time now, can::Duration to_first_sync);
  /// The next SYNC is sent now.
  void begin_cycle(can::Time now);
  /// No SYNC is sent any more: the last step is of this time.
  void end(can::Time now) { cycle_.sync_sent = now; }

  const Cycle& cycle() const { return cycle_; }
  can::Time deadline() const { return deadline_; }  ///< Of the next SYNC.
  can::Duration period() const { return period_; }
  can::Duration waited() const { return waited_; }
  std::uint64_t missed_cycles() const {
    return static_cast<std::uint64_t>((waited_ + period_ / 2) / period_);
  }
  double since_start_s(can::Time time) const { return can::seconds(time - started_); }
  double time_s() const { return since_start_s(cycle_.sync_sent); }  ///< Of this cycle's SYNC.

 private:
  can::Duration period_;
  can::Time started_{};
  can::Time deadline_{};
  can::Duration waited_{};
  Cycle cycle_;
};

}  // namespace hystcan::controller
