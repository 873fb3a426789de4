// A process that makes an output safe after this process has died or has stopped to run.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <functional>

namespace hystcan::node {

// A DAQ card holds its last voltage. The guard is a child process that waits for a lock. The thread that has
// made the guard has this lock, which is robust: the kernel releases it when that thread ends in any way,
// before it returns the memory of the process and closes its files, which takes milliseconds.
//
//   thread ends                  the guard calls `make_safe` and ends
//   no beat() for `patience`     the guard calls `make_safe`, again after each further `patience`, and counts
//                                it in takeovers(): the node has to fault before it drives again
//   trial                        abandon(): the same as the end, and whether the guard has succeeded
//   guard dies                   descriptor() becomes readable: the node has to stop driving
//   guard stops to run           beat() kills it
//
// The guard ignores the signals of a terminal and of a service manager's stop, which come to both processes.

class Guard {
 public:
  using Duration = std::chrono::nanoseconds;

  /// Forks: the guard shares what this process has open, which should be the cards alone. It also calls
  /// `make_safe` at once. Throws RunError.
  Guard(const std::function<bool()>& make_safe, Duration patience);
  ~Guard() { abandon(); }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// Shows the guard that this process runs. The guard waits for the first call.
  void beat() noexcept;
  /// Number of times that this process did not beat; the guard counts before it makes the outputs safe.
  const std::atomic<unsigned>& takeovers() const { return shared_->takeovers; }
  /// Readable, with an end of file, once the guard has died.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }
  /// On the thread that has made the guard. True if the guard has made the outputs safe. Has no effect when
  /// called again.
  bool abandon() noexcept;

 private:
  /// Memory that both processes have.
  struct Shared {
    pthread_mutex_t life{};                 ///< robust; the thread that has made the guard has it
    std::atomic<Duration::rep> beat{0};     ///< last one, CLOCK_MONOTONIC; 0: none
    std::atomic<Duration::rep> watched{0};  ///< when the guard last ran; 0: not yet
    std::atomic<unsigned> takeovers{0};
  };
  static Shared* held_by_this_thread();
  [[noreturn]] static void watch(Shared& shared, int socket, const std::function<bool()>& make_safe,
                                 Duration patience);
  /// True: the thread that has made the guard has ended, or has abandoned it.
  static bool ends(Shared& shared, Duration patience);

  Duration patience_;
  Shared* shared_ = nullptr;
  int socket_ = -1;
  pid_t process_ = -1;
};

}  // namespace hystcan::node
