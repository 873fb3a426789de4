// Clock and timers for code that runs the same in real and in virtual time.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace hystcan::can {

using Duration = std::chrono::nanoseconds;
using Time = std::chrono::time_point<std::chrono::steady_clock, Duration>;

inline double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

/// A one-shot timer. expire_at() allocates nothing; a second call replaces the deadline of the first.
class Timer {
 public:
  virtual ~Timer() = default;  ///< cancels the timer
  virtual void expire_at(Time deadline) = 0;
  virtual void cancel() = 0;
};

/// Clock and timers of one thread: Asio in real time, an event queue in virtual time.
class Scheduler {
 public:
  virtual ~Scheduler() = default;
  virtual Time now() const = 0;
  virtual std::unique_ptr<Timer> make_timer(std::function<void()> on_expiry) = 0;
};

}  // namespace hystcan::can
