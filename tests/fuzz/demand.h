// A condition that a fuzz target checks: the program aborts if it does not hold, which the fuzzer reports.
#pragma once

#include <cstdlib>

namespace hystcan::fuzz {

inline void demand(bool condition) {
  if (!condition) std::abort();
}

}  // namespace hystcan::fuzz
