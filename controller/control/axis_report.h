// The state of an axis and the values of one cycle: what the loop and the axis fill in, and what is logged
// and sent.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/words.h"
#include "controller/control/arming.h"
#include "controller/control/fault.h"
#include "controller/control/following_error.h"
#include "controller/control/gate.h"
#include "controller/control/learning.h"
#include "controller/reference/trajectory.h"

namespace hystcan::controller {

enum class AxisState : std::uint8_t { offline, waiting, initialising, ready, tracking, faulted };
constexpr auto words(AxisState) {
  return std::to_array<std::string_view>(
      {"offline", "waiting", "initialising", "ready", "tracking", "faulted"});
}
constexpr std::string_view to_string(AxisState state) { return word_of(state); }
inline constexpr std::size_t axis_state_count = every<AxisState>().size();
/// In these states a sample and a command are expected in every cycle.
constexpr bool is_in_use(AxisState state) {
  return state > AxisState::waiting && state != AxisState::faulted;
}

struct AxisReport {  // NOLINT(clang-analyzer-optin.performance.Padding)
  AxisState state = AxisState::offline;
  ArmingBlocks arming_blocks{};  ///< what the axis waits for
  /// In the one cycle in which the amplifier's watchdog has passed its trial: the time without commands until
  /// it tripped.
  std::optional<double> watchdog_tripped_after_s{};
  Cause cause = Cause::none;
  double fault_time_s = 0.0;  ///< since the controller's start
  double reference_um =
      0.0;  ///< that the sample is compared with: of the time that it shows; NaN in open loop
  double position_um = 0.0;   ///< last measured
  double previewed_um = 0.0;  ///< fed forward
  double integral_um = 0.0;   ///< of PI
  double demand_um = 0.0;     ///< input of the inverse, after the notch; NaN in open loop
  double drive = 0.0;         ///< output of the gate
  std::uint8_t limits = limit::none;
  std::uint32_t memory_depth = 0;  ///< branches in the model's memory; 0 in open loop
  Learning::Report learning;
  bool sample_missing = false;
  Trajectory::Point point;
  Arrival arrival = Arrival::not_judged;  ///< judged while tracking
};

}  // namespace hystcan::controller
