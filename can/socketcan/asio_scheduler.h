// A Scheduler (can/scheduler.h) in real time, with Boost.Asio.
#pragma once

#include <functional>
#include <memory>

#include "can/scheduler.h"

namespace boost::asio {
class io_context;
}

namespace hystcan::can {

/// The scheduler of an io_context, with the steady clock and absolute deadlines. The context waits for the
/// deadlines and calls the handlers of the timers, unless wait_in_context(false) was called.
class AsioScheduler final : public Scheduler {
 public:
  explicit AsioScheduler(boost::asio::io_context& context);
  Time now() const override;
  std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) override;

  // The three functions below are for a program that waits for the deadlines itself, as in run_in_socket().

  /// Selects who waits for the deadlines. `true`, the initial value: the io_context. `false`: the program,
  /// which must call run_expired() at the time next_deadline().
  void wait_in_context(bool in_context);
  /// Returns the earliest deadline; Time::max() if no timer is set.
  Time next_deadline() const;
  /// Calls the handlers of the expired timers, the earliest first.
  void run_expired();

 private:
  class Impl;
  class AsioTimer;
  std::shared_ptr<Impl> impl_;  ///< shared with timers and a pending wait, which may outlive this object
};

}  // namespace hystcan::can
