// Traps forbidden actions of a control thread: records every system call that is not on a short list, and
// counts the calls of malloc, calloc, realloc and free. Linking trap.cpp replaces the heap of a program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hystcan::support {

/// Restricts this thread until it ends. It may read the clock, wait in epoll, set timers and flags, receive
/// and send. It may read and write only descriptors that are already sockets, timers or event counters at
/// this call. Every other system call fails (ENOSYS) and is recorded. Returns an empty text, or the reason if
/// the kernel does not allow the trap; then only heap calls are counted.
std::string trap_this_thread();

/// Starts or stops recording, so that the calls at the end of the thread do not count.
void watch(bool on);

/// Returns the trapped calls, at most the first 32: "system call 257(0xffffff9c, 0x7f..)".
std::vector<std::string> trapped_calls();
std::uint64_t trapped_call_count();

/// Returns the number of heap calls of the trapped thread while recording was on.
std::uint64_t heap_calls();

}  // namespace hystcan::support
