// Real-time properties that the control thread requests from the kernel.
#pragma once

#include <cstdint>
#include <vector>

namespace hystcan::controller {

struct Realtime {
  static constexpr std::int64_t cpus_max = 1024;  ///< size of the kernel's affinity mask, in processors

  int priority = 0;                ///< SCHED_FIFO 1..99; 0: does not change the thread's scheduling class
  bool lock_memory = false;        ///< locks all pages in memory, so that a cycle never waits for a page
  std::vector<std::int64_t> cpus;  ///< processors on which the control thread may run; empty: not restricted
};

}  // namespace hystcan::controller
