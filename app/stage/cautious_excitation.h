// Chooses the size of an excitation on an unknown stage if no size is stated.
#pragma once

#include "app/stage/open_loop.h"
#include "config/schema/config.h"
#include "controller/control/fault.h"
#include "controller/reference/excitation.h"

namespace hystcan::app {

/// Returns a period of a major loop that keeps it quasi-static: 100 periods of the resonance, at least 2 s.
double quasi_static_period_s(double resonance_Hz);

/// Scales an excitation by `factor`: steps and chirps about their centre, loops about the safe drive, where
/// every run begins and ends.
controller::Excitation::Config resized(controller::Excitation::Config excitation, double factor,
                                       double safe_drive);

/// Drives a loop of a tenth of the range about the safe drive, then of three tenths. Returns `whole`, or the
/// largest part of it that keeps the position within its limits. Prints notes about the measured loops.
/// `config` has one axis. Throws RunError at a signal, and at a fault that a smaller excitation would not
/// avoid.
controller::Excitation::Hysteresis tried_small_first(const config::Config& config, const twin::Config& twin,
                                                     const OpenLoopOptions& run,
                                                     const controller::Excitation::Hysteresis& whole);

/// Chooses the amplitude of steps or a chirp by trying it with the twin before the stage moves. Returns the
/// first of `whole`, its half, its quarter ... that passes a rehearsal with a margin of 2: no fault, at most
/// half of position_jump_um between samples, and twice the travel within position_min_um and position_max_um.
/// Prints a note if the result is not `whole`. `config` has one axis. Throws RunError if no amplitude passes.
controller::Excitation::Config with_margin(const config::Config& config, const twin::Config& twin,
                                           const controller::Excitation::Config& whole);

/// Returns true if the position left its limits, which a smaller excitation may avoid.
bool is_of_size(const controller::Fault& fault);

}  // namespace hystcan::app
