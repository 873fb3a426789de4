#include "app/report/identified_plant.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "app/report/dynamics_text.h"
#include "controller/analysis/held_plant.h"
#include "identification/dynamics/sampled_dataset.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::Estimate;
using identification::SecondOrderFit;

double lag_s(const controller::Delays& delays) {
  return 1.0 / (2.0 * std::numbers::pi * delays.amplifier_bandwidth_Hz);
}

/// The record with the output that this chain has for the same drive.
Dataset simulated(Dataset record, controller::Delays chain, double gain) {
  chain.command_delay = {};  // the drive of a row is in force from its time on
  const identification::Grid grid = identification::grid_of(record.time_s);
  const Eigen::VectorXd drive = identification::held_on(grid, record.input);
  const controller::PlantRecursion::Config plant = controller::HeldPlant(chain, grid.cycle_s).recursion();
  auto state = controller::PlantRecursion::at_rest(drive[0]);
  Eigen::VectorXd position(grid.length());
  for (Eigen::Index n = 0; n < grid.length(); ++n)
    position[n] = controller::PlantRecursion::step(plant, state,
                                                   drive[std::max<Eigen::Index>(n - plant.delay_cycles, 0)]);
  for (std::size_t row = 0; row < record.output.size(); ++row)
    record.output[row] = gain * position[grid.cycles[row]];
  return record;
}

std::optional<SecondOrderFit> seen(const Dataset& record, const controller::Delays& chain, double gain) {
  try {
    return identification::fit_second_order(simulated(record, chain, gain));
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// The chain that the fit sees as what it has found in the record.
controller::Delays inferred(const Dataset& record, const SecondOrderFit& found, controller::Delays chain,
                            bool lag_is_known) {
  constexpr int iterations = 4;
  for (int i = 0; i < iterations; ++i) {
    const auto as_seen = seen(record, chain, found.gain.value);
    if (!as_seen) return chain;
    const double lag = lag_s(chain) + found.delay_s.value - as_seen->delay_s.value;
    if (!lag_is_known && lag <= 0.0) return chain;
    if (!lag_is_known) chain.amplifier_bandwidth_Hz = 1.0 / (2.0 * std::numbers::pi * lag);
    chain.resonance_Hz *= found.natural_frequency_Hz.value / as_seen->natural_frequency_Hz.value;
    chain.damping_ratio *= found.damping_ratio.value / as_seen->damping_ratio.value;
  }
  return chain;
}

}  // namespace

IdentifiedPlant identified_plant(const Dataset& record, const SecondOrderFit& fit,
                                 const controller::Delays& present) {
  controller::Delays chain = present;
  chain.resonance_Hz = fit.natural_frequency_Hz.value;
  chain.damping_ratio = fit.damping_ratio.value;
  const double interpolated_s = present.interpolated ? 0.5 * fit.cycle_s : 0.0;
  const Estimate own = later(fit.delay_s, -present.sensor_s() - interpolated_s);
  const std::optional<double> bandwidth_Hz = bandwidth_Hz_for(own);
  chain.amplifier_bandwidth_Hz = bandwidth_Hz.value_or(present.amplifier_bandwidth_Hz);
  chain = inferred(record, fit, chain, !bandwidth_Hz);

  const double stretch = chain.resonance_Hz / fit.natural_frequency_Hz.value,
               damped = chain.damping_ratio / fit.damping_ratio.value;
  IdentifiedPlant plant{
      .delays = chain,
      .uncertainty = {
          .resonance_Hz = {stretch * fit.natural_frequency_Hz.lo, stretch * fit.natural_frequency_Hz.hi},
          .damping_ratio = {damped * fit.damping_ratio.lo, damped * fit.damping_ratio.hi}}};
  const double longer_s = bandwidth_Hz ? 0.0 : own.value - lag_s(chain);
  plant.uncertainty.longer_s = {own.lo - own.value + longer_s, own.hi - own.value + longer_s};
  plant.delays.resonance_Hz = rounded(chain.resonance_Hz);
  plant.delays.damping_ratio = rounded(chain.damping_ratio);
  if (bandwidth_Hz) plant.delays.amplifier_bandwidth_Hz = rounded(chain.amplifier_bandwidth_Hz);
  return plant;
}

}  // namespace hystcan::app
