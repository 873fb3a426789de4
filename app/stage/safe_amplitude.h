// The amplitude of an experiment that nobody has stated: the twin tries it before the stage does.
#pragma once

#include <functional>

#include "config/schema/config.h"
#include "controller/reference/excitation.h"

namespace hystcan::app {

/// The first of `amplitude`, its half, its quarter ... that a rehearsal with the twin passes with a margin of 2: no fault,
/// at most half of position_jump_um from sample to sample, and twice the travel within position_min_um and
/// position_max_um. `config` has one axis. Throws RunError where none does.
double amplitude_with_margin(const config::Config& config, const twin::Config& twin, double amplitude,
                             const std::function<controller::Excitation::Config(double)>& excitation);

}  // namespace hystcan::app
