// What the control thread asks of the kernel, and what it says where it is refused.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/realtime.h"

namespace hystcan::app {

/// Applies it to the calling thread (memory: to the process). One line for each thing refused: what, why, and
/// how to get it. Nothing refused ends a run.
std::vector<std::string> apply(const controller::Realtime& realtime);

/// The parts; empty where granted. Memory is locked only where no limit can be met later, for with one an
/// allocation past it would fail in the middle of a run.
std::optional<std::string> take_priority(int priority);
std::optional<std::string> keep_to_cpus(const std::vector<std::int64_t>& cpus);
std::optional<std::string> lock_memory();
/// Whether lock_memory() would refuse; nothing is locked.
std::optional<std::string> find_memory_lock_refusal();

/// A capability of this process (linux/capability.h), by its number.
bool has_capability(int number);

}  // namespace hystcan::app
