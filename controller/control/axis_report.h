// The state of an axis and the values of one cycle. Axis and loop fill them in; the log and the status frames
// contain them.
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
/// True if a sample and a command are expected in every cycle of this state.
constexpr bool is_in_use(AxisState state) {
  return state > AxisState::waiting && state != AxisState::faulted;
}

struct AxisReport {  // NOLINT(clang-analyzer-optin.performance.Padding)
  AxisState state = AxisState::offline;
  ArmingBlocks arming_blocks{};  ///< what the axis waits for
  /// Set only in the cycle in which the amplifier's watchdog passes its trial: the time without commands
  /// until it tripped.
  std::optional<double> watchdog_tripped_after_s{};
  Cause cause = Cause::none;
  double fault_time_s = 0.0;  ///< time of the fault, since the controller's start
  /// Reference with which the sample is compared, at the time of the sampled position; NaN in open loop.
  double reference_um = 0.0;
  double position_um = 0.0;   ///< last measured position
  double previewed_um = 0.0;  ///< output of the feed-forward
  double integral_um = 0.0;   ///< integral part of PI
  double demand_um = 0.0;     ///< input of the inverse, after the notch; NaN in open loop
  double drive = 0.0;         ///< output of the gate
  std::uint8_t limits = limit::none;
  std::uint32_t memory_depth = 0;  ///< branches in the model's memory; 0 in open loop
  Learning::Report learning;
  bool sample_missing = false;
  Trajectory::Point point;
  Arrival arrival = Arrival::not_judged;  ///< judged only while the axis tracks
};

}  // namespace hystcan::controller
