// The size of an excitation, where it is not stated, on an unknown stage.
#pragma once

#include "app/stage/open_loop.h"
#include "config/schema/config.h"
#include "controller/control/fault.h"
#include "controller/reference/excitation.h"

namespace hystcan::app {

/// Of a major loop: 100 periods of the resonance, but at least 2 s, so that the loop is quasi-static.
double quasi_static_period_s(double resonance_Hz);

/// The excitation `factor` times as large: steps and chirps about the same centre, loops about the safe
/// drive, where every run begins and ends.
controller::Excitation::Config resized(controller::Excitation::Config excitation, double factor,
                                       double safe_drive);

/// Drives a loop of a tenth of the range about the safe drive, then of three tenths. Returns `whole`, or as
/// large a part of it as keeps the position within its limits. Notes what it saw. `config` has one axis.
/// Throws RunError at a signal, and at a fault that has nothing to do with the size.
controller::Excitation::Hysteresis tried_small_first(const config::Config& config, const twin::Config& twin,
                                                     const OpenLoopOptions& run,
                                                     const controller::Excitation::Hysteresis& whole);

/// Steps or a chirp of an amplitude that is not given: the twin tries them before the stage does. The first
/// of `whole`, its half, its quarter ... that a rehearsal with the twin passes with a margin of 2: no fault,
/// at most half of position_jump_um from sample to sample, and twice the travel within position_min_um and
/// position_max_um. Notes if it is not `whole`. `config` has one axis. Throws RunError where none passes.
controller::Excitation::Config with_margin(const config::Config& config, const twin::Config& twin,
                                           const controller::Excitation::Config& whole);

/// True: the position has left its limits, which a smaller excitation may keep to.
bool is_of_size(const controller::Fault& fault);

}  // namespace hystcan::app
