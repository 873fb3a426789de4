// The processor time of a benchmark.
#pragma once

#include <time.h>

namespace hystcan::bench {

/// The processor time of this thread; other programs and threads do not count.
inline double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace hystcan::bench
