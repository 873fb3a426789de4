// The real-time settings that the control thread asks the kernel for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/realtime.h"

namespace hystcan::app {

/// Applies the settings to the calling thread (memory: to the process). Returns one line for each setting
/// that the kernel refuses: what, why, and the remedy. A refusal does not end a run.
std::vector<std::string> apply(const controller::Realtime& realtime);

/// All threads allocate from one heap, so that what one of them frees serves the next one. Before other
/// threads begin. The control thread allocates nothing while the interface is there, and so waits for none.
void share_heap();

/// The single settings. Each returns the refusal, or nothing if it is granted. lock_memory() refuses if there
/// is a limit on locked memory: an allocation above that limit would fail in the middle of a run.
std::optional<std::string> take_priority(int priority);
std::optional<std::string> keep_to_cpus(const std::vector<std::int64_t>& cpus);
std::optional<std::string> lock_memory();
/// The refusal that lock_memory() would return; locks nothing.
std::optional<std::string> find_memory_lock_refusal();

/// True if this process has the capability with this number (linux/capability.h).
bool has_capability(int number);

}  // namespace hystcan::app
