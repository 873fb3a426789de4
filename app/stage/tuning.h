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

/// The three kinds of feed-forward, each as values of Delays::second_order and Delays::plant_inverse. The
/// first kind compensates the mean delay, the second kind also the variance, and the third kind inverts the
/// plant.
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
/// rule holds for the whole uncertainty of the plant. The resonance may even be outside its interval by
/// `resonance_percent` (of its frequency).
controller::LoopConfig cautious_loop(const IdentifiedPlant& plant, double rate_Hz, double resonance_percent,
                                     const controller::CautiousRule& rule);

/// Rehearses candidates for the loop and chooses the best one (see best_of()). The first candidate is the
/// present setting. The others are designed by the report's members `rule` and `cautious_rule`, each with the
/// feed-forward that has the smallest predicted error. The twin gets the identified plant. A design is not
/// rehearsed if it is unstable at a corner of the plant's uncertainty (a combination of the ends of its
/// intervals). Throws RunError if no candidate tracks, or at a signal.
void evaluate(TuningReport& report, const IdentifiedPlant& plant, const config::Config& config,
              const twin::Config& twin);

/// Adds to an evaluated report: the promise, the offer of a better cycle rate, and the predicted outcomes of
/// the present and the proposed loop with every structure of the control law (by_structure).
void predict_further(TuningReport& report, const config::Config& config, const twin::Config& twin);

/// Returns, for each segment of a reference, the true RMS error in um that no setpoints can avoid
/// (controller/analysis/feed_forward_design.h). An element is `nullopt` if this error is not known for the
/// segment, or if the stage has a second mode.
std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s);

}  // namespace hystcan::app
