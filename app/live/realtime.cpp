#include "app/live/realtime.h"

#include <fmt/format.h>
#include <linux/capability.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>

namespace hystcan::app {
namespace {

std::string words_of(int error) { return std::generic_category().message(error); }

constexpr const char* memory_cure =
    "set ulimit -l unlimited (LimitMEMLOCK=infinity in a systemd unit), or grant CAP_IPC_LOCK";

constexpr std::size_t page_bytes = 4096;

void touch(volatile std::byte* memory, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; i += page_bytes) memory[i] = std::byte{1};
}

/// Writes to each memory page of a stack area that is larger than a cycle needs. The kernel provides a page
/// at the first access, and the control thread must not wait for that during a cycle.
void touch_stack() {
  std::array<std::byte, std::size_t{256} * 1024> room;
  touch(room.data(), room.size());
}

/// Reserves memory for the heap, so that a later allocation does not wait for new pages from the kernel.
/// Freed memory is not returned to the kernel, and large blocks are allocated from the heap, too. A reload
/// needs half a megabyte for a moment, and so does the start of the threads.
void keep_heap() {
  constexpr std::size_t reserve_bytes = std::size_t{2} * 1024 * 1024;
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  if (auto* memory = static_cast<std::byte*>(std::malloc(reserve_bytes))) {
    touch(memory, reserve_bytes);
    std::free(memory);
  }
}

}  // namespace

bool has_capability(int number) {
  std::ifstream status("/proc/self/status");
  constexpr std::string_view key = "CapEff:";
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key))
      return (std::strtoull(line.c_str() + key.size(), nullptr, 16) >> static_cast<unsigned>(number) & 1U) !=
             0;
  return false;
}

int node_priority(const controller::Realtime& of_controller) {
  if (of_controller.priority == 0) return 0;
  return std::min(of_controller.priority + 1, sched_get_priority_max(SCHED_FIFO));
}

void share_heap() { mallopt(M_ARENA_MAX, 1); }

std::optional<RunError> take_priority(int priority) {
  const sched_param fifo{.sched_priority = priority};
  if (sched_setscheduler(0, SCHED_FIFO, &fifo) == 0) return std::nullopt;
  const int error = errno;
  return RunError(
      fmt::format("priority {} (SCHED_FIFO) was refused: {}", priority, words_of(error)),
      {.remedy = fmt::format("raise ulimit -r (LimitRTPRIO={} in a systemd unit), or grant CAP_SYS_NICE",
                             priority)});
}

std::optional<RunError> keep_to_cpus(const std::vector<std::int64_t>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::string list;
  for (const std::int64_t cpu : cpus) {
    CPU_SET(static_cast<std::size_t>(cpu), &set);
    list += fmt::format("{}{}", list.empty() ? "" : ",", cpu);
  }
  if (sched_setaffinity(0, sizeof set, &set) == 0) return std::nullopt;
  const int error = errno;
  return RunError(
      fmt::format("cpus [{}] were refused: {}", list, words_of(error)),
      {.remedy =
           "set cpus to processors that are online (/sys/devices/system/cpu/online) and in the process's "
           "cpuset (AllowedCPUs= in a systemd unit)"});
}

std::optional<RunError> find_memory_lock_refusal() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (limit.rlim_cur == RLIM_INFINITY || has_capability(CAP_IPC_LOCK)) return std::nullopt;
  return RunError(
      fmt::format("lock_memory was refused: locked memory is limited to {} kB, so an allocation could fail",
                  limit.rlim_cur / 1024),
      {.remedy = memory_cure});
}

std::optional<RunError> lock_memory() {
  if (auto refusal = find_memory_lock_refusal()) return refusal;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    return RunError(fmt::format("lock_memory was refused: {}", words_of(errno)), {.remedy = memory_cure});
  touch_stack();
  keep_heap();
  return std::nullopt;
}

std::vector<std::string> apply(const controller::Realtime& realtime) {
  std::vector<std::string> refused;
  const auto note = [&](const std::optional<RunError>& refusal) {
    if (refusal) refused.emplace_back(refusal->what());
  };
  if (realtime.lock_memory) note(lock_memory());
  if (!realtime.cpus.empty()) note(keep_to_cpus(realtime.cpus));
  if (realtime.priority > 0) note(take_priority(realtime.priority));
  return refused;
}

}  // namespace hystcan::app
