// What `hystcan tune` chooses from: the present setting and the designs for the identified plant, each rehearsed.
#pragma once

#include <vector>

#include "app/report/dynamics_text.h"
#include "app/report/tuning_report.h"
#include "config/schema/config.h"

namespace hystcan::app {

struct CandidateRules {
  controller::SensitivityRule sensitivity;
  controller::CautiousRule cautious;
  bool only_cautious = false;
};

/// The plant of an axis whose commands take effect at the next SYNC.
IdentifiedPlant identified_plant(const config::Config& config, const identification::SecondOrderFit& fit);

/// The present one is the first. `config` has one axis. The twin gets the identified mode; a loop that is not stable at
/// all corners is not rehearsed. A design compensates delays to the first or to the second order, as is predicted to be
/// better. Throws RunError at a signal.
std::vector<Candidate> rehearsed_candidates(const config::Config& config, const twin::Config& twin,
                                            const identification::SecondOrderFit& fit,
                                            const CandidateRules& rules);

/// Fills by_structure.
void predict_structures(Candidate& candidate, const config::Config& config, const twin::Config& twin,
                        const identification::SecondOrderFit& fit);

}  // namespace hystcan::app
