// What an axis is configured with, and what follows from it.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "controller/control/following_error.h"
#include "controller/control/gate.h"
#include "controller/control/law.h"
#include "controller/control/learning.h"
#include "controller/control/output_check.h"
#include "controller/control/plant_inverse.h"
#include "controller/control/ramp_check.h"
#include "controller/control/supervisor.h"
#include "controller/reference/excitation.h"
#include "controller/reference/trajectory.h"
#include "model/coupling.h"

namespace hystcan::controller {

/// How an axis obtains the memory of its actuator's hysteresis before it tracks.
enum class MemorySource : std::uint8_t {
  wipe,     ///< drives to both thresholds, which wipes all memory out
  assume,   ///< assumes that the drive rose monotonically from the lower threshold to the reported drive
  restore,  ///< uses the memory saved at the last clean stop (Axis::restore)
};
constexpr auto words(MemorySource) { return std::to_array<std::string_view>({"wipe", "assume", "restore"}); }

struct AxisConfig {
  ControlLaw::Config law;
  Gate::Config gate;
  Delays delays;
  std::optional<PlantInverse::Config> plant_inverse{};  ///< designed for `delays`, where these ask for it
  std::vector<Segment> setpoint;
  std::optional<Learning::Config> learning{};  ///< empty: it learns nothing
  bool repeat = false;
  ReferenceLimits reference_limits{};
  ReferenceLimits transition_limits{};  ///< of transitions alone, beside those: default_transition_limits
  std::optional<InPosition::Config> in_position{};  ///< empty: not judged
  MemorySource start_up = MemorySource::wipe;
  double wipe_slew_per_s = 100.0;  ///< drive units/s, to the thresholds and at the stop to the safe drive
  double wipe_dwell_s = 0.1;       ///< rest at each threshold
  double fault_ramp_per_s = 0.0;   ///< drive units/s, to the safe drive after a fault; 0: at once
  std::chrono::nanoseconds enable_delay{0};  ///< the least time from Enable until the drive moves
  bool verify_watchdog = false;  ///< withholds commands once, before the first use: the amplifier must trip
  std::vector<model::Coupling> couplings{};  ///< fed forward; a row of the matrix
  Supervisor::Config supervision{};
  FollowingError::Config following_error{};
  std::optional<Excitation::Config> excitation{};  ///< open loop: replaces law and setpoint

  AxisCommand safe_command() const { return {.drive = gate.safe_drive}; }
};

/// Limits of transitions for which the configuration gives no others:
///
///   v = S g / 2,   g = (x_hi - x_lo) / (v_hi - v_lo)         S: slew limit of the drive
///   a = w^2 (x_hi - x_lo) / 1000,   w = 2 pi resonance       x: of the model, at its thresholds v_lo, v_hi
///
/// v: where a branch is half as steep as the mean gain g, the drive of a transition needs exactly S. On
/// steeper parts the gate leaves the rest to PI. a: a mode of frequency w lags behind an acceleration a by a
/// / w^2. This is a thousandth of the stroke, less than the tracking error; a transition therefore does not
/// excite the mode.
ReferenceLimits default_transition_limits(const Gate::Config& gate, const model::HysteresisParameters& model,
                                          const Delays& delays);

/// The amplitude at which an oscillation of the error is an unstable loop: half of following_error_um and a
/// third of position_jump_um, so that it is mostly decided before these two, and at most a twentieth of the
/// plausible positions. Infinite where the law has no feedback.
double oscillation_amplitude_um(const AxisConfig& config);

/// r(t) as the axis follows it, and the limits of its transitions.
Trajectory reference_of(const AxisConfig& config);
TransitionLimits transition_limits_of(const AxisConfig& config);

/// What the parts of an axis are configured with.
Supervisor::Config supervision_of(const AxisConfig& config);
OutputCheck output_check_of(const AxisConfig& config);
RampCheck::Config ramp_check_of(const AxisConfig& config);

/// Allowed positions of a live setpoint: what the model reaches, within what is plausible.
model::Interval reach_of(const AxisConfig& config);

/// Drives between the model's thresholds.
model::Interval model_drives(const model::HysteresisParameters& model, const Gate::Config& gate);

/// Positions that the model reaches with this drive: from its lower threshold (or drive_min), coming down
/// from the upper one, to the upper threshold (or drive_max) on the ascending reference curve.
model::Interval model_reach_um(const model::HysteresisParameters& model, const Gate::Config& gate);

}  // namespace hystcan::controller
