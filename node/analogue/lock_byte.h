// A lock that shows other processes which output is driven.
#pragma once

#include <fcntl.h>

namespace hystcan::node {

/// Locks a byte of a file. A child process that inherits the open file also owns the lock. Returns false if
/// a process that opened the file separately has the lock.
inline bool lock_byte(int file, off_t byte) {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return fcntl(file, F_OFD_SETLK, &lock) == 0;
}

}  // namespace hystcan::node
