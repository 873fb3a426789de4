// Hours of faults in virtual time. Troubles are drawn at random from a seed, alone or several at once; each
// lasts from one cycle to two seconds. Requests clear and enable the axis at random times after them.
//
// An episode is judged when its troubles are over:
//   - a trouble that lasted long enough must have been detected;
//   - a single trouble must have led to one of its causes;
//   - clear and enable must lead back to tracking, and the axis must track until the next episode begins.
// The wire monitor judges every frame.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "controller/control/fault.h"
#include "tests/support/fault_rig.h"

namespace hystcan::support {

/// The longest time from the frame that decides a fault to the safe command, among the episodes in which the
/// bus carries frames.
struct SafeTime {
  double worst_ms = 0.0;
  std::string episode;
};

/// The results of one kind of trouble.
struct TroubleCount {
  std::uint64_t drawn = 0;
  std::uint64_t alone = 0;  ///< faults in episodes without another trouble
  double within_ms = 0.0;   ///< a trouble of at least this duration must be detected
  double latest_ms = 0.0;   ///< longest time from the beginning of a trouble to the fault, among single
                            ///< troubles of at least within_ms

  /// Returns the bound of latest_ms: the first frame that shows a trouble arrives within a cycle of the
  /// trouble's beginning, and the next control step decides.
  double bound_ms() const { return within_ms + 2.0; }
};

struct StormResult {
  double virtual_s = 0.0;
  std::uint64_t cycles = 0;
  std::uint64_t episodes = 0;
  std::uint64_t faults = 0;
  std::uint64_t must_be_detected = 0;  ///< episodes with a trouble that lasted long enough
  std::uint64_t undetected = 0;
  std::uint64_t late = 0;  ///< single troubles that were detected later than bound_ms()
  std::uint64_t other_cause = 0;
  std::uint64_t stuck = 0;
  std::uint64_t without_trouble = 0;  ///< faults between two episodes
  std::uint64_t unsafe = 0;           ///< episodes in which the wire monitor found a violation
  std::uint64_t commands = 0;
  SafeTime in_a_step;      ///< for faults that a control step decides
  SafeTime between_steps;  ///< for faults after which the next control step sends the safe command
  double steepest = 0.0;   ///< largest step of the drive, relative to the slew limit
  std::array<std::uint64_t, controller::cause_count> by_cause{};
  std::array<TroubleCount, trouble_count> by_trouble{};
  std::int64_t resident_after_warm_up_kB = 0;
  std::int64_t resident_at_end_kB = 0;
  std::vector<std::string> failures;  ///< descriptions of the first few failures of each kind

  bool has_passed() const { return undetected + late + other_cause + stuck + without_trouble + unsafe == 0; }
};

struct StormConfig {
  std::uint64_t seed = 1;
  double virtual_s = 60.0;
  double warm_up_s = 10.0;  ///< time at which the measurement of the process memory starts
};

StormResult run_storm(const StormConfig& storm);
void print(const StormResult& result);

/// Returns the resident memory of this process, from /proc/self/statm.
std::int64_t resident_kB();

}  // namespace hystcan::support
