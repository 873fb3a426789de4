// A Scheduler (can/scheduler.h) in virtual time, for simulations.
#pragma once

#include <functional>
#include <memory>

#include "can/scheduler.h"

namespace hystcan::can {

/// A discrete-event scheduler in virtual time. Timers that expire at the same instant run in the order in
/// which they were set.
class VirtualClock final : public Scheduler {
 public:
  VirtualClock();
  ~VirtualClock() override;

  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

  /// Runs the handler of every timer that expires up to and including `end`; the time is then `end`. A timer
  /// whose deadline is in the past expires now. A handler must not call this function.
  void run_until(Time end);

 private:
  class Queue;
  struct Alarm;
  std::shared_ptr<Queue> queue_;  ///< shared with the timers, because a timer may outlive the clock
};

}  // namespace hystcan::can
