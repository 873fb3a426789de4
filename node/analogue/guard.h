// The guard: a second process that makes the outputs of a node safe after the node's process died or stopped
// running.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <functional>

namespace hystcan::node {

// A DAQ card holds its last voltage. The guard is a child process that waits for a lock. The thread that
// created the guard owns this lock, which is robust: the kernel releases the lock when that thread ends for
// any reason, before it frees the memory and closes the files of the process. This cleanup can take
// milliseconds.
//
//   thread ends                  the guard calls `make_safe` and exits
//   no beat() for `patience`     the guard calls `make_safe`, repeats it after each further `patience`, and
//                                increments takeovers(): the node must report a fault before it drives again
//   test, or normal end          abandon() releases the lock and returns whether the guard succeeded
//   guard dies                   descriptor() becomes readable: the node must stop driving
//   guard stops running          beat() kills the guard
//
// The guard ignores the stop signals of a terminal and of a service manager, which both processes receive.

class Guard {
 public:
  using Duration = std::chrono::nanoseconds;

  /// Forks this process. The guard inherits all open files of this process: only the cards should be open at
  /// this call. The guard calls `make_safe` once at its start. Throws RunError if the guard can't be started.
  Guard(const std::function<bool()>& make_safe, Duration patience);
  ~Guard() { abandon(); }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// Tells the guard that this process is running. From the first call on, the guard expects the next call
  /// within `patience`.
  void beat() noexcept;
  /// Returns how often this process did not call beat() in time. The guard increments this count before it
  /// makes the outputs safe.
  const std::atomic<unsigned>& takeovers() const { return shared_->takeovers; }
  /// Returns a file descriptor that becomes readable, with an end of file, when the guard dies.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }
  /// Orders the guard process to make the outputs safe and to end. Call this function on the thread that
  /// created the guard. Returns true if the guard succeeded. A second call has no effect and returns false.
  bool abandon() noexcept;

 private:
  /// Memory that both processes share.
  struct Shared {
    pthread_mutex_t life{};                 ///< robust mutex, locked by the thread that created the guard;
                                            ///< the kernel releases the mutex when this thread ends
    std::atomic<Duration::rep> beat{0};     ///< time of the last beat, CLOCK_MONOTONIC; 0: none
    std::atomic<Duration::rep> watched{0};  ///< time at which the guard last ran; 0: it has not run yet
    std::atomic<unsigned> takeovers{0};
  };
  static Shared* held_by_this_thread();
  [[noreturn]] static void watch(Shared& shared, int socket, const std::function<bool()>& make_safe,
                                 Duration patience);
  /// Waits until the next beat is due. Returns true earlier if the thread that created the guard ends or
  /// calls abandon().
  static bool ends(Shared& shared, Duration patience);

  Duration patience_;
  Shared* shared_ = nullptr;
  int socket_ = -1;
  pid_t process_ = -1;
};

}  // namespace hystcan::node
