// Chooses the size of an excitation for an unknown stage if the user does not state a size.
#pragma once

#include "app/stage/open_loop.h"
#include "config/schema/config.h"
#include "controller/control/fault.h"
#include "controller/reference/excitation.h"

namespace hystcan::app {

/// Returns the duration in s of a major loop that is slow enough to be quasi-static: 100 periods of the
/// resonance, at least 2 s.
double quasi_static_period_s(double resonance_Hz);

/// Multiplies the size of an excitation by `factor`. The centre of steps and chirps does not change. Loops
/// grow or shrink around the safe drive, because every run begins and ends there.
controller::Excitation::Config resized(controller::Excitation::Config excitation, double factor,
                                       double safe_drive);

/// Drives the stage in small loops around the safe drive: first over a tenth of the drive range of `whole`,
/// then over three tenths. Prints the measured ranges. Returns `whole`, or the same excitation with a smaller
/// drive range that should keep the position within its limits. `config` must have one axis. Throws RunError
/// at a signal or a fault, and if the position falls while the drive rises.
controller::Excitation::Hysteresis tried_small_first(const config::Config& config, const twin::Config& twin,
                                                     const OpenLoopOptions& run,
                                                     const controller::Excitation::Hysteresis& whole);

/// Chooses the amplitude of steps or a chirp by rehearsals with the twin, before the stage moves. Tries
/// `whole`, then half its amplitude, a quarter, and so on. Returns the first excitation that causes no fault
/// and has a margin of two: twice its movement between two samples would not exceed position_jump_um, and
/// twice its distance from the first position would not exceed the position limits. Prints a note if the
/// amplitude was reduced. `config` must have one axis. Throws RunError if no amplitude is small enough.
controller::Excitation::Config with_margin(const config::Config& config, const twin::Config& twin,
                                           const controller::Excitation::Config& whole);

/// Returns true if the fault is a position beyond its limits or a position jump. A smaller excitation may
/// avoid these faults.
bool is_of_size(const controller::Fault& fault);

}  // namespace hystcan::app
