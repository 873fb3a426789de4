// The real-time settings that the control thread requests from the kernel.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "controller/realtime.h"

namespace hystcan::app {

/// Applies priority and CPUs to the calling thread, and locks the memory of the whole process. Returns one
/// line for each setting that the kernel refuses: setting, reason and remedy. A refusal does not end a run.
std::vector<std::string> apply(const controller::Realtime& realtime);

/// Returns the real-time priority of `hystcan node`; 0 if no priority is configured. It is one above the
/// priority of the control thread. If both run on one processor, the node therefore reads its sensors at a
/// SYNC before the control thread, which needs these samples, continues.
int node_priority(const controller::Realtime& of_controller);

/// Makes all threads allocate from one heap, so that each thread can use the memory that another one freed.
/// Call it before other threads start. The control thread never waits for the lock of this heap, because it
/// does not allocate while the CAN interface is up.
void share_heap();

/// Each of these functions applies one setting and returns the refusal; nullopt if the setting is granted.
/// lock_memory() refuses if locked memory is limited: an allocation above that limit would fail during a run.
std::optional<RunError> take_priority(int priority);
std::optional<RunError> keep_to_cpus(const std::vector<std::int64_t>& cpus);
std::optional<RunError> lock_memory();
/// Returns the refusal that lock_memory() would return, without locking.
std::optional<RunError> find_memory_lock_refusal();

/// Returns true if this process has the capability with this number (linux/capability.h).
bool has_capability(int number);

}  // namespace hystcan::app
