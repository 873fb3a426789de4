// Traps what a control thread must not do: every system call that is not on a short list, and every call of
// malloc, calloc, realloc and free. The program that links trap.cpp has its heap replaced by one that counts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hystcan::support {

/// From here on, and for good, this thread may read the clock, wait in epoll, set timers, receive and send;
/// read and write only on descriptors that are sockets, timers or event counters now. Whatever else it calls
/// fails (ENOSYS) and is recorded. Empty where that was done, else the reason.
std::string trap_this_thread();

/// Records only while `on`; what the thread does to end does not count.
void watch(bool on);

/// Each call trapped while watched: "openat(0xffffff9c, 0x7f..)", at most the first 32.
std::vector<std::string> trapped_calls();
std::uint64_t trapped_call_count();

/// Of the trapped thread while watched.
std::uint64_t heap_calls();

}  // namespace hystcan::support
