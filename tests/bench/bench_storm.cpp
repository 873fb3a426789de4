// A day of random faults in virtual time, under the monitor on the wire.
//
//   bench_storm [HOURS = 24] [SEED = 1]      exit status 1 if any requirement is not met
#include <algorithm>
#include <cstdlib>

#include "tests/bench/short_run.h"
#include "tests/support/storm.h"

int main(int argc, char** argv) {
  using namespace hystcan::support;
  namespace bench = hystcan::bench;
  constexpr double hour_s = 3600.0;
  constexpr std::int64_t resident_may_grow_kB = 256;
  const double hours = argc > 1 ? std::strtod(argv[1], nullptr) : bench::full_or_short(24.0, 0.1);
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
  const double warm_up_hours = std::min(1.0, 0.5 * hours);
  const StormResult result =
      run_storm({.seed = seed, .virtual_s = hours * hour_s, .warm_up_s = hour_s * warm_up_hours});
  print(result);
  const bool memory_is_constant =
      result.resident_at_end_kB <= result.resident_after_warm_up_kB + resident_may_grow_kB;
  const bool is_safe_in_time = result.in_a_step.worst_ms <= safe_in_a_step_ms &&
                               result.between_steps.worst_ms <= safe_between_steps_ms;
  return result.has_passed() && is_safe_in_time && memory_is_constant ? 0 : 1;
}
