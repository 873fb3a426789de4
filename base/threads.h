// Threads beside the control thread.
#pragma once

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>
#include <utility>

namespace hystcan {

/// Lowers the priority of the calling thread: it runs only when the control thread does not need the
/// processor, whatever priority the process was started with.
inline void yield_to_the_control_thread() {
  const sched_param ordinary{.sched_priority = 0};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10);
}

/// A thread that no signal reaches.
template <class Work>
std::thread thread_without_signals(Work work) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::move(work));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

}  // namespace hystcan
