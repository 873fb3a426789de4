// A process that makes an output safe after this process has died, whatever killed it.
#pragma once

#include <sys/types.h>

#include <functional>

namespace hystcan::node {

// A DAQ card holds its last voltage. The guard is a child process that waits for the end of a pipe, of which
// this process has the only other end: the kernel closes it when this process ends in any way.
//
//   node ends in any way  the guard calls `make_safe` and ends
//   trial                 abandon(): the same, and whether the guard has succeeded
//   guard dies            descriptor() becomes readable: the node has to stop driving
//
// The guard ignores the signals of a terminal and of a service manager's stop, which come to both processes.

class Guard {
 public:
  /// Forks: the guard shares what this process has open, which should be the cards alone. Throws RunError.
  explicit Guard(const std::function<bool()>& make_safe);
  ~Guard() { abandon(); }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  /// Readable, with an end of file, once the guard has died.
  int descriptor() const { return socket_; }
  pid_t process() const { return process_; }
  /// True if the guard has made the outputs safe. No effect when called again.
  bool abandon() noexcept;

 private:
  int socket_ = -1;
  pid_t process_ = -1;
};

}  // namespace hystcan::node
