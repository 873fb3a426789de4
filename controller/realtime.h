// What the control thread asks of the kernel.
#pragma once

#include <cstdint>
#include <vector>

namespace hystcan::controller {

struct Realtime {
  static constexpr std::int64_t cpus_max = 1024;  ///< as many as the kernel's plain affinity mask holds

  int priority = 0;          ///< SCHED_FIFO 1..99; 0: the scheduling class that the program was started in
  bool lock_memory = false;  ///< no page is given back or read from a disk in the middle of a cycle
  std::vector<std::int64_t> cpus;  ///< the processors the control thread may run on; empty: wherever it may
};

}  // namespace hystcan::controller
