// Traps what a control thread must not do: it records every system call that is not on a short list, and
// counts the calls of malloc, calloc, realloc and free. A program that links trap.cpp has its heap replaced.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hystcan::support {

/// Restricts this thread until it ends. It may read the clock, wait in epoll, set timers, receive and send;
/// it may read and write only on descriptors that are sockets, timers or event counters now. Every other
/// system call fails (ENOSYS) and is recorded. Returns an empty text, or why the kernel does not allow it.
std::string trap_this_thread();

/// Records only while `on`: the calls by which the thread ends do not count.
void watch(bool on);

/// The calls trapped while watched, at most the first 32: "system call 257(0xffffff9c, 0x7f..)".
std::vector<std::string> trapped_calls();
std::uint64_t trapped_call_count();

/// The heap calls of the trapped thread while watched.
std::uint64_t heap_calls();

}  // namespace hystcan::support
