// The configuration of an axis, and values derived from it.
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
  /// Feed-forward that inverts the plant, designed for `delays`; empty unless delays.plant_inverse is set.
  std::optional<PlantInverse::Config> plant_inverse{};
  std::vector<Segment> setpoint;
  std::optional<Learning::Config> learning{};  ///< empty: no learning
  bool repeat = false;
  ReferenceLimits reference_limits{};
  /// Additional limits for transitions only; see default_transition_limits().
  ReferenceLimits transition_limits{};
  std::optional<InPosition::Config> in_position{};  ///< empty: the axis does not judge its arrival
  MemorySource start_up = MemorySource::wipe;
  /// Drive units/s: ramps to the thresholds, and to the safe drive at a stop.
  double wipe_slew_per_s = 100.0;
  double wipe_dwell_s = 0.1;      ///< rest at each threshold during a wipe
  double fault_ramp_per_s = 0.0;  ///< drive units/s: ramp to the safe drive after a fault; 0: no ramp
  std::chrono::nanoseconds enable_delay{0};  ///< minimum time from Enable until the drive moves
  bool verify_watchdog = false;  ///< withholds commands once before the first use: the amplifier must trip
  std::vector<model::Coupling> couplings{};  ///< effects of other axes on this one; feed-forward removes them
  Supervisor::Config supervision{};
  FollowingError::Config following_error{};
  std::optional<Excitation::Config> excitation{};  ///< open loop: replaces law and setpoint

  AxisCommand safe_command() const { return {.drive = gate.safe_drive}; }
};

/// Limits of transitions if the configuration contains none:
///
///   v = S g / 2,   g = (x_hi - x_lo) / (v_hi - v_lo)         S: slew limit of the drive
///   a = w^2 (x_hi - x_lo) / 1000,   w = 2 pi resonance       x: of the model, at its thresholds v_lo, v_hi
///
/// v: if a branch is half as steep as the mean gain g, the drive of a transition needs exactly S. On steeper
/// parts the gate limits the drive, and PI corrects the rest. a: a mode of frequency w lags behind an
/// acceleration a by a / w^2. This is a thousandth of the stroke, less than the tracking error, so a
/// transition does not excite the mode.
ReferenceLimits default_transition_limits(const Gate::Config& gate, const model::HysteresisParameters& model,
                                          const Delays& delays);

/// Returns the amplitude above which an oscillation of the error counts as an unstable loop: half of
/// following_error_um and a third of position_jump_um, so that the oscillation is mostly found before one of
/// these two limits trips, and at most a twentieth of the range of plausible positions. Infinite if the law
/// has no feedback.
double oscillation_amplitude_um(const AxisConfig& config);

/// Return r(t) of the axis, and the limits of its transitions.
Trajectory reference_of(const AxisConfig& config);
TransitionLimits transition_limits_of(const AxisConfig& config);

/// Return the configuration of each part of an axis.
Supervisor::Config supervision_of(const AxisConfig& config);
OutputCheck output_check_of(const AxisConfig& config);
RampCheck::Config ramp_check_of(const AxisConfig& config);

/// Returns the allowed positions of a live setpoint: within the model's reach (model_reach_um) and within the
/// plausible positions.
model::Interval reach_of(const AxisConfig& config);

/// Returns the drives that are between the model's thresholds and within the gate's range.
model::Interval model_drives(const model::HysteresisParameters& model, const Gate::Config& gate);

/// Returns the positions that the model reaches with these drives: from its lower threshold (or drive_min) on
/// the branch from the upper threshold, to the upper threshold (or drive_max) on the ascending reference
/// curve.
model::Interval model_reach_um(const model::HysteresisParameters& model, const Gate::Config& gate);

}  // namespace hystcan::controller
