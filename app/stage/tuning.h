// Tunes the loop of one axis: drives small steps, identifies the dynamics, designs loops and rehearses them.
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

/// The three kinds of feed-forward, as values of Delays::second_order and Delays::plant_inverse: mean delay,
/// second order, plant inverse.
inline constexpr std::array<std::pair<bool, bool>, 3> feed_forwards{
    {{false, false}, {true, false}, {false, true}}};

/// Drives the steps in open loop and returns drive and position of every cycle. Throws RunError if the steps
/// do not finish.
identification::Dataset measured_steps(const config::Config& config, const twin::Config& twin,
                                       const OpenLoopOptions& run,
                                       const controller::Excitation::Steps& steps);

/// Returns a new report with the default rules, without plant and candidates.
TuningReport tuning_of(const config::Config& config);

/// Identifies the dynamics of the axis from a record of steps. Throws RunError if the record does not
/// determine them.
IdentifiedPlant plant_of_steps(const identification::Dataset& record, const config::Config& config);

/// Returns a loop with the largest gains that the cautious rule allows for the plant at this cycle rate. The
/// rule must hold within the plant's uncertainty, with the interval of the resonance widened by
/// `resonance_percent`.
controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double rate_Hz, double resonance_percent,
                                     const controller::CautiousRule& rule);

/// Rehearses candidates for the loop and chooses the best one (see best_of()). The first candidate is the
/// present setting. The others are designs by the rules of the report, each with the feed-forward that has
/// the smallest predicted error. The twin gets the identified plant. A design is not rehearsed if it is
/// unstable at a corner of the plant's uncertainty (a combination of the ends of its intervals). Throws
/// RunError if no candidate tracks, or at a signal.
void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin);

/// Adds to an evaluated report: predictions for every structure (by_structure) with the present and the
/// proposed loop, the promise, and the offer of a better rate.
void predict_further(TuningReport& report, const config::Config& config, const twin::Config& twin);

/// Returns, for each segment of a reference, the true RMS error in um that no setpoints can avoid
/// (controller/analysis/feed_forward_design.h). An element is `nullopt` if this error is not known for the
/// segment, or if the stage has a second mode.
std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s);

}  // namespace hystcan::app
