// The scheduler in virtual time.
#pragma once

#include <functional>
#include <memory>

#include "can/scheduler.h"

namespace hystcan::can {

/// A discrete-event scheduler. Events at the same instant run in the order in which their timers were set.
class VirtualClock final : public Scheduler {
 public:
  VirtualClock();
  ~VirtualClock() override;

  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

  /// Runs every event up to and including `end`; the time is then `end`. A deadline in the past is due now.
  /// An event must not call this function.
  void run_until(Time end);

 private:
  class Queue;
  struct Alarm;
  std::shared_ptr<Queue> queue_;  ///< shared, because a timer may outlive the clock and then never expires
};

}  // namespace hystcan::can
