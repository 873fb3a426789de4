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

/// The source from which an axis takes the memory of its actuator's hysteresis before it tracks.
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
  /// Additional limits that apply only to transitions; see default_transition_limits().
  ReferenceLimits transition_limits{};
  std::optional<InPosition::Config> in_position{};  ///< empty: the axis does not decide if it is in position
  MemorySource start_up = MemorySource::wipe;
  /// Slew in drive units/s of the ramps to the thresholds, and to the safe drive at a stop.
  double wipe_slew_per_s = 100.0;
  double wipe_dwell_s = 0.1;  ///< time of rest at each threshold during a wipe
  /// Slew of the ramp to the safe drive after a fault, drive units/s; 0: no ramp.
  double fault_ramp_per_s = 0.0;
  std::chrono::nanoseconds enable_delay{0};  ///< minimum time from Enable until the drive moves
  bool verify_watchdog = false;  ///< before the first use, withholds commands once: the amplifier must trip
  std::vector<model::Coupling> couplings{};  ///< effects of other axes on this one; feed-forward removes them
  Supervisor::Config supervision{};
  FollowingError::Config following_error{};
  /// In open loop, replaces law and setpoint; empty: closed loop.
  std::optional<Excitation::Config> excitation{};

  AxisCommand safe_command() const { return {.drive = gate.safe_drive}; }
};

/// Returns the limits of motion for transitions (from segment to segment, and to a live setpoint or another
/// reference) that apply if the configuration contains no such limits:
///
///   v = S g / 2               maximum velocity; S: slew limit of the drive, g: mean gain of the model
///   a = w^2 stroke / 1000     maximum acceleration; w: angular frequency of the mode
///
/// The mean gain g is the stroke of the model divided by the distance of its thresholds. On a branch half as
/// steep as g, the drive of a transition with the velocity v needs exactly the slew S. On steeper parts, the
/// drive needs less slew; on flatter parts the gate limits the drive, and PI corrects the rest. A mode lags
/// behind an acceleration a by a / w^2. This is a thousandth of the stroke, less than the tracking error, so
/// a transition does not excite the mode.
ReferenceLimits default_transition_limits(const Gate::Config& gate, const model::HysteresisParameters& model,
                                          const Delays& delays);

/// Returns the amplitude above which an oscillation of the error counts as an unstable loop. It is the
/// smallest of half of following_error_um, a third of position_jump_um, and a twentieth of the range of
/// plausible positions. So the oscillation is mostly found before one of the first two limits trips. Returns
/// infinity if the law has no feedback, or if PI is too weak to make the mode grow.
double oscillation_amplitude_um(const AxisConfig& config);

/// Return the reference r(t) of the axis, and the limits of its transitions.
Trajectory reference_of(const AxisConfig& config);
TransitionLimits transition_limits_of(const AxisConfig& config);

/// Return the configurations of the parts of an axis: supervisor, output check and ramp check.
Supervisor::Config supervision_of(const AxisConfig& config);
OutputCheck output_check_of(const AxisConfig& config);
RampCheck::Config ramp_check_of(const AxisConfig& config);

/// Returns the range of positions that a live setpoint may have: the positions that the model reaches
/// (model_reach_um) and that are also plausible.
model::Interval reach_of(const AxisConfig& config);

/// Returns the range of drives that are both between the model's thresholds and within the gate's range.
model::Interval model_drives(const model::HysteresisParameters& model, const Gate::Config& gate);

/// Returns the range of positions that the model reaches with the drives in model_drives(). The drive falls
/// to the lowest of these drives. So the range begins with the position at this drive on the descending
/// reference curve. The drive rises to the highest of these drives. So the range ends with the position at
/// this drive on the ascending reference curve.
model::Interval model_reach_um(const model::HysteresisParameters& model, const Gate::Config& gate);

}  // namespace hystcan::controller
