// Tunes the loop of one axis from an experiment of small steps: identifies the mode and rehearses designs for
// it.
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

/// The choices of Delays::second_order and plant_inverse: mean delay, second order, plant inverse.
inline constexpr std::array<std::pair<bool, bool>, 3> feed_forwards{
    {{false, false}, {true, false}, {false, true}}};

/// Runs the steps and returns drive and position of every cycle. Throws RunError if the steps do not finish.
identification::Dataset measured_steps(const config::Config& config, const twin::Config& twin,
                                       const OpenLoopOptions& run,
                                       const controller::Excitation::Steps& steps);

/// Returns a report with the usual rules, before a record is evaluated: without plant and candidates.
TuningReport tuning_of(const config::Config& config);

/// Identifies the plant from the record. Throws RunError if the record does not determine a plant.
IdentifiedPlant plant_of_steps(const identification::Dataset& record, const config::Config& config);

/// Returns the largest gains that a cautious rule allows for a plant at this rate, with the uncertainty of
/// the resonance widened by `resonance_percent`.
controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double rate_Hz, double resonance_percent,
                                     const controller::CautiousRule& rule);

/// Rehearses the candidates for the plant and chooses one. The first candidate is the present setting; the
/// others are designs by the rules of the report, each with the feed-forward that has the best prediction.
/// The twin gets the identified plant; a design that is not stable at all corners is not rehearsed. Throws
/// RunError if no candidate tracks, or at a signal.
void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin);

/// Sets by_structure of the present and the proposed candidate, and the promise. `report` must be evaluated.
void predict_further(TuningReport& report, const config::Config& config, const twin::Config& twin);

/// Returns the error that no setpoints can avoid: the floor of the true error
/// (controller/analysis/feed_forward_design.h) of a reference on a stage, in um RMS for each segment;
/// `nullopt` if the segment has no floor or the stage has a second mode.
std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s);

}  // namespace hystcan::app
