// The report of an axis on one cycle: its state and its values. Axis and ClosedLoop fill the report in; the
// log and the status frames show it.
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
/// True if the axis expects a sample and sends a command in every cycle of this state.
constexpr bool is_in_use(AxisState state) {
  return state > AxisState::waiting && state != AxisState::faulted;
}

struct AxisReport {  // NOLINT(clang-analyzer-optin.performance.Padding)
  AxisState state = AxisState::offline;
  ArmingBlocks arming_blocks{};  ///< conditions for which the axis waits
  /// Time without commands until the amplifier's watchdog tripped. It is set only in the cycle of the trip,
  /// during the trial of the watchdog at start-up.
  std::optional<double> watchdog_tripped_after_s{};
  Cause cause = Cause::none;
  double fault_time_s = 0.0;  ///< time of the fault since the controller's start
  /// Reference with which the sample is compared: the reference at the time when the position was sampled.
  /// NaN in open loop.
  double reference_um = 0.0;
  double position_um = 0.0;   ///< last measured position
  double previewed_um = 0.0;  ///< output of the feed-forward
  double integral_um = 0.0;   ///< integral part of PI
  double demand_um = 0.0;     ///< demanded position, after the notch; NaN in open loop
  double drive = 0.0;         ///< commanded drive, the output of the gate
  std::uint8_t limits = limit::none;
  std::uint32_t memory_depth = 0;  ///< number of branches in the model's memory; 0 in open loop
  Learning::Report learning;
  bool sample_missing = false;
  Trajectory::Point point;
  /// Decision whether the stage is in position; only while the axis tracks.
  Arrival arrival = Arrival::not_judged;
};

}  // namespace hystcan::controller
