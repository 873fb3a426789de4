#include "controller/sync_clock.h"

#include "can/protocol/node.h"

namespace hystcan::controller {

void SyncClock::start(can::Time now, can::Duration to_first_sync) {
  started_ = cycle_.sync_sent = now;
  deadline_ = now + to_first_sync;
}

/// Begins a cycle. Missed cycles are not repeated: if a SYNC is more than half a cycle late, deadlines and
/// references continue from the time of this SYNC.
void SyncClock::begin_cycle(can::Time now) {
  const bool is_first = cycle_.sync_counter == 0;
  const can::Duration since_last = now - cycle_.sync_sent;
  const can::Duration lateness = now - deadline_;
  if (2 * lateness > period_) {
    deadline_ = now;
    waited_ += lateness;
  }
  deadline_ += period_;
  cycle_ = {.sync_counter = can::next_sync_counter(cycle_.sync_counter),
            .sync_sent = now,
            .lateness = lateness,
            .sync_period = is_first ? can::Duration::zero() : since_last,
            .dt_s = can::seconds(since_last)};
}

}  // namespace hystcan::controller
