// A claim that a fuzz target makes: the fuzzer hears of it where it does not hold.
#pragma once

#include <cstdlib>

namespace hystcan::fuzz {

inline void demand(bool claim) {
  if (!claim) std::abort();
}

}  // namespace hystcan::fuzz
