// A scheduler whose timers expire too late, as on an overloaded computer.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "can/scheduler.h"

namespace hystcan::support {

/// Timers that are set while `by` is not zero expire later by that time.
class Oversleeper final : public can::Scheduler {
 public:
  explicit Oversleeper(can::Scheduler& clock) : clock_(clock) {}
  can::Time now() const override { return clock_.now(); }
  std::unique_ptr<can::Timer> make_timer(std::function<void()> on_expiry) override {
    return std::make_unique<LateTimer>(*this, clock_.make_timer(std::move(on_expiry)));
  }
  can::Duration by{};

 private:
  class LateTimer final : public can::Timer {
   public:
    LateTimer(const Oversleeper& owner, std::unique_ptr<can::Timer> timer)
        : owner_(owner), timer_(std::move(timer)) {}
    void expire_at(can::Time deadline) override { timer_->expire_at(deadline + owner_.by); }
    void cancel() override { timer_->cancel(); }

   private:
    const Oversleeper& owner_;
    std::unique_ptr<can::Timer> timer_;
  };

  can::Scheduler& clock_;
};

}  // namespace hystcan::support
