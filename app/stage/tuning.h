// The loop of one axis from an experiment of small steps: the mode is found, and designs for it are rehearsed.
#pragma once

#include "app/stage/frequency_response.h"
#include "app/stage/open_loop.h"
#include "app/stage/tune_candidates.h"
#include "app/stage/tuning_report.h"
#include "config/schema/config.h"
#include "identification/dataset.h"

namespace hystcan::app {

/// Up and down around the middle of the range of the drive by 1 % of it, five times.
controller::Excitation::Steps usual_steps(const controller::Gate::Config& gate);

/// The steps with a smaller amplitude where the twin comes near a limit (amplitude_with_margin), which is noted.
/// `config` has one axis.
controller::Excitation::Steps with_safe_amplitude(const controller::Excitation::Steps& steps,
                                                  const config::Config& config, const twin::Config& twin);

/// Drive and position in every cycle of the steps. Throws RunError if they do not come to their end.
identification::Dataset measured_steps(const config::Config& config, const twin::Config& twin,
                                       const OpenLoopOptions& run,
                                       const controller::Excitation::Steps& steps);

/// What is known of the experiment before it is evaluated: everything but fit, plant and candidates.
TuningReport tuning_of(const config::Config& config, const controller::Excitation::Steps& steps,
                       const CandidateRules& rules, bool rehearsed);

/// The plant behind the record. Throws RunError where the record determines none.
IdentifiedPlant plant_of_steps(const identification::Dataset& record, const config::Config& config);

/// Rehearses the candidates for the plant and chooses one. Throws RunError if no candidate tracks, or at a signal.
void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin, const CandidateRules& rules);

/// Measured response, mode, and the loops before and after. `report` is evaluated.
FrequencyResponse response_of(const TuningReport& report, const identification::Dataset& record);

}  // namespace hystcan::app
