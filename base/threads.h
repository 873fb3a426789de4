// Helpers for threads that run beside the control thread.
#pragma once

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>
#include <utility>

namespace hystcan {

/// Lowers the priority of the calling thread, so that it does not delay the control thread. Also works if the
/// process was started with a real-time priority.
inline void yield_to_the_control_thread() {
  const sched_param ordinary{.sched_priority = 0};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
}

/// Blocks all signals in the calling thread, and in threads that it starts, until the object is destroyed.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

/// Starts a thread in which all signals are blocked. Throws std::system_error if the system cannot start a
/// thread.
template <class Work>
std::thread thread_without_signals(Work work) {
  const BlockedSignals blocked;
  return std::thread(std::move(work));
}

}  // namespace hystcan
