// The short form of the benchmarks (tests/bench/run_short): each runs all of its code once, with little work.
// It shows that a benchmark works; its figures are not judged.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace hystcan::bench {

/// Returns whether this is a short run.
inline bool is_short() { return std::getenv("HYSTCAN_BENCH_SHORT") != nullptr; }

/// Chooses the amount of work.
template <class Amount>
Amount full_or_short(Amount full, Amount brief) {
  return is_short() ? brief : full;
}

/// Prints a line above the figures of a short run.
inline void announce_short_run() {
  if (is_short()) std::puts("short run: the figures are not judged");
}

/// Judges a figure against its budget.
inline const char* verdict(bool is_met) {
  if (is_short()) return "not judged";
  return is_met ? "met" : "missed";
}

}  // namespace hystcan::bench
