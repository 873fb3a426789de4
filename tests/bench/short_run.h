// The short form of the benchmarks (tests/bench/run --short): each executes all of its code with little work.
// Ratios are judged as in the full form (tests/bench/budgets.h).
#pragma once

#include <cstdlib>

namespace hystcan::bench {

/// Returns whether this is a short run.
inline bool is_short() { return std::getenv("HYSTCAN_BENCH_SHORT") != nullptr; }

/// Chooses the amount of work.
template <class Amount>
Amount full_or_short(Amount full, Amount brief) {
  return is_short() ? brief : full;
}

}  // namespace hystcan::bench
