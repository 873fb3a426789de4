// A process that makes an output safe after this process has died, whatever killed it.
#pragma once

#include <pthread.h>
#include <sys/types.h>

#include <functional>

namespace hystcan::node {

// A DAQ card holds its last voltage. The guard is a child process that waits for a lock. The thread that has
// made the guard has this lock, which is robust: the kernel releases it when that thread ends in any way,
// before it returns the memory of the process and closes its files, which takes milliseconds.
//
//   thread ends           the guard calls `make_safe` and ends
//   trial                 abandon(): the same, and whether the guard has succeeded
//   guard dies            descriptor() becomes readable: the node has to stop driving
//
// The guard ignores the signals of a terminal and of a service manager's stop, which come to both processes.

class Guard {
 public:
  /// Forks: the guard shares what this process has open, which should be the cards alone. It also calls
  /// `make_safe` at once. Throws RunError.
  explicit Guard(const std::function<bool()>& make_safe);
  ~Guard() { abandon(); }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// Readable, with an end of file, once the guard has died.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }
  /// On the thread that has made the guard. True if the guard has made the outputs safe. Has no effect when
  /// called again.
  bool abandon() noexcept;

 private:
  pthread_mutex_t* life_ = nullptr;  ///< in memory that both processes have
  int socket_ = -1;
  pid_t process_ = -1;
};

}  // namespace hystcan::node
