// The loop of one axis from an experiment of small steps: the mode is found, and designs for it are
// rehearsed.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "app/stage/open_loop.h"
#include "app/stage/tuning_report.h"
#include "config/schema/config.h"
#include "identification/dataset.h"

namespace hystcan::app {

/// What Delays::second_order and plant_inverse can be: the mean delay, the second order, the inverse.
inline constexpr std::array<std::pair<bool, bool>, 3> feed_forwards{
    {{false, false}, {true, false}, {false, true}}};

/// Drive and position in every cycle of the steps. Throws RunError if they do not come to their end.
identification::Dataset measured_steps(const config::Config& config, const twin::Config& twin,
                                       const OpenLoopOptions& run,
                                       const controller::Excitation::Steps& steps);

/// What is known before a record is evaluated, with the usual rules: no plant and no candidates.
TuningReport tuning_of(const config::Config& config);

/// The plant behind the record. Throws RunError where the record determines none.
IdentifiedPlant plant_of_steps(const identification::Dataset& record, const config::Config& config);

/// The largest gains by a cautious rule for a plant, at this rate, with the resonance wider by a share.
controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double rate_Hz, double resonance_percent,
                                     const controller::CautiousRule& rule);

/// Rehearses the candidates for the plant and chooses one. The first candidate is the present setting; the
/// others are designs by the rules of the report, each with the feed-forward that is predicted to be best.
/// The twin gets the identified plant; a design that is not stable at all corners is not rehearsed. Throws
/// RunError if no candidate tracks, or at a signal.
void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin);

/// Fills by_structure of the present and the proposed candidate, and the promise. `report` is evaluated.
void predict_further(TuningReport& report, const config::Config& config, const twin::Config& twin);

/// What no setpoints can avoid: the floor of the true error (controller/analysis/feed_forward_design.h) of a
/// reference on a stage. um RMS of each segment; none where it has no floor, or the stage a second mode.
std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s);

}  // namespace hystcan::app
