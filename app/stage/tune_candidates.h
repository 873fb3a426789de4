// What `hystcan tune` chooses from: the present setting and the designs for the identified plant, each rehearsed.
#pragma once

#include <optional>
#include <vector>

#include "app/stage/identified_plant.h"
#include "app/stage/tuning_report.h"
#include "config/schema/config.h"

namespace hystcan::app {

struct CandidateRules {
  controller::SensitivityRule sensitivity;
  controller::CautiousRule cautious;
  bool only_cautious = false;
};

/// The present one is the first. `config` has one axis. The twin gets the identified plant; a design that is not stable
/// at all corners is not rehearsed. A design has the feed-forward that is predicted to be best. Throws RunError at a signal.
std::vector<Candidate> rehearsed_candidates(const config::Config& config, const twin::Config& twin,
                                            const IdentifiedPlant& plant, const CandidateRules& rules);

/// Fills by_structure.
void predict_structures(Candidate& candidate, const config::Config& config, const twin::Config& twin,
                        const IdentifiedPlant& plant);

/// All of a delay becomes the sensor's, or the amplifier's lag.
void set_delay(twin::AxisConfig& axis, double delay_s, bool is_the_sensors);

/// Of a candidate that has run. Empty where the configuration states the sensor's delay.
std::optional<DelayShares> delay_shares(const Candidate& candidate, const config::Config& config,
                                        const twin::Config& twin, const IdentifiedPlant& plant);

}  // namespace hystcan::app
