// Clock and timers for code that runs unchanged in real time and in virtual time.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace hystcan::can {

using Duration = std::chrono::nanoseconds;
using Time = std::chrono::time_point<std::chrono::steady_clock, Duration>;

inline double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

/// A one-shot timer. expire_at() allocates no memory; a second call replaces the deadline of the first call.
class Timer {
 public:
  virtual ~Timer() = default;  ///< cancels the timer
  virtual void expire_at(Time deadline) = 0;
  virtual void cancel() = 0;
};

/// Clock and timers of one thread. In real time, Asio runs the timers; in virtual time, an event queue.
class Scheduler {
 public:
  virtual ~Scheduler() = default;
  virtual Time now() const = 0;
  virtual std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) = 0;
};

}  // namespace hystcan::can
