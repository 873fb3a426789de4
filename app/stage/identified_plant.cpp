#include "app/stage/identified_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "app/stage/chain_record.h"
#include "app/stage/dynamics_text.h"
#include "base/text.h"
#include "identification/characterisation.h"

namespace hystcan::app {
namespace {

using identification::Dataset;
using identification::Estimate;
using identification::SecondOrderFit;
using Found = ChainRecord::Fit;

// Bounds of the fitted delay, in cycles.
constexpr double least_late = 1e-3, most_late = identification::largest_delay_cycles;
constexpr double stated_share = 0.1;  // largest relative error of a stated resonance
constexpr double most_damping_ratio = 5.0, least_damping_ratio = 1e-4;

double interpolation_s(const controller::Delays& stated, double cycle_s) {
  return stated.interpolated ? 0.5 * cycle_s : 0.0;
}

/// Returns true if fit `a` explains the record better than fit `b`, by more than noise can cause.
bool is_better(const ChainRecord& record, const Found& a, const Found& b) {
  return b.sum_of_squares - a.sum_of_squares > record.confidence(a).as_good();
}

/// Returns true if the record rules out the stated mode: the mode `shown` explains the record better than the
/// stated mode. If the stated mode is above 0.45 of the rate, the shown mode must be much better, because the
/// stated mode with another damping would appear almost the same in the samples.
bool excludes(const ChainRecord& record, const Found& shown, const Found& as_stated,
              const controller::Delays& stated) {
  constexpr double beyond = 0.45, by_far = 0.5;
  const double share = stated.resonance_Hz * record.cycle_s() > beyond ? by_far : 1.0;
  return shown.sum_of_squares < share * as_stated.sum_of_squares && is_better(record, shown, as_stated);
}

/// Fixes the lag to `lag` cycles and keeps the total of lag and pure delay. Fits the mode again.
Found with_lag(const ChainRecord& record, const Found& found, double lag) {
  ChainPoint at = found.at;
  at[pure_share] = std::clamp(1.0 - lag / at[late_cycles], 0.0, found.box.max()[pure_share]);
  ChainBox box = found.box;
  for (ChainPoint* end : {&box.min(), &box.max()}) {
    (*end)[late_cycles] = at[late_cycles];
    (*end)[pure_share] = at[pure_share];
  }
  Found known = record.improved(at, box);
  known.box = found.box;
  return known;
}

/// Splits the total delay into lag and pure delay if the split explains the record significantly better than
/// the lag alone. If the record does not determine the lag of this split, the lag is the one that the user
/// stated. Splits nothing if the user stated the delay of the sensor: no other link has a pure delay.
Found with_pure_delay(const ChainRecord& record, const Found& lag_alone, const controller::Delays& stated) {
  constexpr double most_share = 0.98, least_cycles = 0.05;
  if (stated.sensor_delay.count() > 0) return lag_alone;
  Found best = lag_alone;
  ChainBox box = lag_alone.box;
  box.min()[pure_share] = 0.0;
  box.max()[pure_share] = most_share;
  // If the frequency of the mode is near half the cycle rate, a delay changes the samples like a shift of
  // this frequency. The search then also starts at shifted frequencies.
  constexpr double far_from_half = 0.2;  // limit of the distance from half the rate, as a share of the rate
  const double cycles = std::exp(lag_alone.at[log_frequency]) * record.cycle_s();
  const bool is_near_half = std::abs(cycles - 0.5) < far_from_half;
  for (const double moved : is_near_half ? std::vector{0.0, -0.07, 0.07} : std::vector{0.0})
    for (const double share : {0.3, 0.7}) {
      ChainPoint start = lag_alone.at;
      start[pure_share] = share;
      start[log_frequency] += moved;
      const Found found = record.improved(start, box);
      if (found.sum_of_squares < best.sum_of_squares) best = found;
    }
  if (best.at[pure_share] * best.at[late_cycles] < least_cycles) return lag_alone;
  if (!is_better(record, best, lag_alone)) return lag_alone;
  const Found as_stated = with_lag(record, best, stated.lag_s() / record.cycle_s());
  return is_better(record, best, as_stated) ? best : as_stated;
}

/// Fits the chain (mode, lag and delay) near the mode that the record shows. `late`: sum of lag and delay in
/// cycles. The search starts from this sum; if `lag_is_known`, the sum is fixed.
Found around_mode(const ChainRecord& record, const SecondOrderFit& mode, double late, bool lag_is_known) {
  constexpr double reach = 0.4;  // largest change of log(frequency) from the given mode
  const ChainPoint start{std::log(mode.natural_frequency_Hz.value), std::log(mode.damping_ratio.value), late,
                         0.0};
  ChainBox box{start, start};
  box.min()[log_frequency] -= reach;
  box.max()[log_frequency] += reach;
  box.min()[log_damping] = std::log(least_damping_ratio);
  box.max()[log_damping] = std::log(most_damping_ratio);
  if (!lag_is_known) {
    box.min()[late_cycles] = least_late;
    box.max()[late_cycles] = most_late;
  }
  return record.improved(start, box);
}

/// Tries several delays with a fixed mode, log(frequency / Hz) and log(damping ratio). Returns the best of
/// these delays, from which a search with a free delay can start.
Found with_any_delay(const ChainRecord& record, double log_f, double log_zeta) {
  Found best{{}, std::numeric_limits<double>::infinity(), {}};
  for (const double late : {0.05, 0.15, 0.4, 1.0, 2.5}) {
    const ChainPoint point{log_f, log_zeta, late, 0.0};
    const double sum_of_squares = record.sum_of_squares(point);
    if (sum_of_squares < best.sum_of_squares) best = {point, sum_of_squares, {point, point}};
  }
  best.box.min()[late_cycles] = least_late;
  best.box.max()[late_cycles] = most_late;
  return best;
}

/// Fits the chain if the record shows no mode. One fit has exactly the stated mode. Other fits have a mode
/// whose frequency differs from the stated one by at most 10 %, because the samples may contain a weak trace
/// of the true mode at a lower frequency. Returns the best of these other fits if it explains the record
/// significantly better, otherwise the fit with the stated mode.
Found around_stated(const ChainRecord& record, const controller::Delays& stated) {
  constexpr double step = 0.02;  // step of the frequency search, as a share of the rate
  // How far log(damping ratio) may go below and above the stated value. Most stages have more damping than
  // assumed.
  constexpr double less_damping = 0.7, more_damping = 1.8;
  const double log_f = std::log(stated.resonance_Hz),
               log_zeta = std::log(std::max(stated.damping_ratio, least_damping_ratio));
  Found plain = with_any_delay(record, log_f, log_zeta);
  plain = record.improved(plain.at, plain.box);
  // Two modes whose frequencies differ by the cycle rate give almost the same samples. A search of half the
  // cycle rate to each side of the stated frequency therefore covers all cases.
  const double half_Hz = 0.5 / record.cycle_s();
  const double reach_Hz = std::min(stated_share * stated.resonance_Hz, half_Hz);
  const double step_Hz = std::min(step / record.cycle_s(), 0.25 * reach_Hz);
  const int count = 1 + static_cast<int>(2.0 * reach_Hz / step_Hz);
  std::vector<Found> starts(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    starts[static_cast<std::size_t>(i)] =
        with_any_delay(record, std::log(stated.resonance_Hz - reach_Hz + i * step_Hz), log_zeta);
  std::ranges::stable_sort(starts, {}, [](const Found& of) { return of.sum_of_squares; });
  constexpr std::size_t tried = 3;
  starts.resize(std::min(starts.size(), tried));
  Found best = plain;
  for (Found& start : starts) {
    start.box.min()[log_frequency] = log_f + std::log1p(-stated_share);
    start.box.max()[log_frequency] = log_f + std::log1p(stated_share);
    start.box.min()[log_damping] = log_zeta - less_damping;
    start.box.max()[log_damping] = log_zeta + more_damping;
    start = record.improved(start.at, start.box);
    const bool rings_endlessly =
        start.at[log_damping] < start.box.min()[log_damping] + 0.01;  // a mode at this bound fits noise only
    if (!rings_endlessly && start.sum_of_squares < best.sum_of_squares) best = start;
  }
  return is_better(record, best, plain) ? best : plain;
}

/// Scales an estimate to the new `value`. Its error and its interval keep their relative size.
Estimate scaled(Estimate estimate, double value) {
  const double factor = value / estimate.value;
  for (double* of : {&estimate.value, &estimate.standard_error, &estimate.lo, &estimate.hi}) *of *= factor;
  return estimate;
}

controller::PlantUncertainty uncertainty_of(const SecondOrderFit& mode) {
  return {.resonance_Hz = {mode.natural_frequency_Hz.lo, mode.natural_frequency_Hz.hi},
          .damping_ratio = {mode.damping_ratio.lo, mode.damping_ratio.hi}};
}

/// Returns the uncertainty if the record shows no mode. The interval of the resonance then extends from the
/// stated frequency to infinity, because the record gives no upper limit. The true damping may be lower than
/// stated.
controller::PlantUncertainty uncertainty_of(const controller::Delays& stated,
                                            const controller::Delays& chain) {
  const auto [least, most] = std::minmax(stated.damping_ratio, chain.damping_ratio);
  return {.resonance_Hz = {stated.resonance_Hz, std::numeric_limits<double>::infinity()},
          .damping_ratio = {least / stated_damping_factor, most}};
}

void find_mode(IdentifiedPlant& plant, const Dataset& record) {
  try {
    plant.mode = identification::fit_second_order(record);
  } catch (const identification::ModeNotShown& error) {
    plant.not_shown = error.what();
  }
}

/// Returns true if the record shows a mode, but its total delay (lag and pure delay) cannot be distinguished
/// from zero. The plant then keeps the lag that the user stated.
bool keeps_lag(const IdentifiedPlant& plant) { return plant.mode && !(plant.late_s.lo > 0.0); }

Found of_shown(IdentifiedPlant& plant, const ChainRecord& chain, const controller::Delays& stated) {
  const double cycle_s = chain.cycle_s();
  plant.late_s = later(plant.mode->delay_s, -stated.sensor_s() - interpolation_s(stated, cycle_s));
  const double late_s = keeps_lag(plant) ? stated.lag_s() : plant.late_s.value;
  const Found found =
      around_mode(chain, *plant.mode, std::max(late_s / cycle_s, least_late), keeps_lag(plant));
  return keeps_lag(plant) ? found : with_pure_delay(chain, found, stated);
}

/// Returns `found`. Throws if the delay in the record is shorter than the stated delay of the sensor. The
/// delay in the record contains the delay of the sensor, so the stated delay must then be wrong.
Found accepted(const Found& found, const IdentifiedPlant& plant, const ChainRecord& chain,
               const controller::Delays& stated) {
  if (plant.late_s.hi < -0.1 * chain.cycle_s())
    refuse("the sensor's stated delay is ", rounded(1e3 * stated.sensor_s()), " ms, expected at most ",
           rounded(1e3 * plant.mode->delay_s.value),
           " ms, the delay from drive to position in the record, which includes the delay of the sensor");
  return found;
}

/// Returns the best chain for the record. A mode that the record shows is used only if it agrees with the
/// stated mode, or if the record rules out the stated mode.
Found best_of(IdentifiedPlant& plant, const ChainRecord& chain, const controller::Delays& stated) {
  Found found;
  if (plant.mode) {
    found = of_shown(plant, chain, stated);
    if (is_as_stated(*plant.mode, stated.resonance_Hz)) return accepted(found, plant, chain, stated);
  }
  Found as_stated = with_pure_delay(chain, around_stated(chain, stated), stated);
  if (plant.mode && excludes(chain, found, as_stated, stated)) return accepted(found, plant, chain, stated);
  if (plant.mode)
    plant.not_shown = fmt::format(
        "a mode at the stated {:.4g} Hz with a delay explains the record as well as a mode at {:.4g} Hz",
        stated.resonance_Hz, plant.mode->natural_frequency_Hz.value);
  plant.mode.reset();
  return as_stated;
}

/// Sets the uncertainty of the plant if the record shows a mode. The fit of the mode alone (plant.mode) gave
/// intervals for frequency and damping. The later fit of the whole chain gave more exact values, `exact`, but
/// no intervals. The intervals are therefore scaled to these values.
void set_intervals(IdentifiedPlant& plant, const controller::Delays& exact) {
  plant.mode->natural_frequency_Hz = scaled(plant.mode->natural_frequency_Hz, exact.resonance_Hz);
  plant.mode->damping_ratio = scaled(plant.mode->damping_ratio, exact.damping_ratio);
  plant.uncertainty = uncertainty_of(*plant.mode);
  const double longer_s = keeps_lag(plant) ? plant.late_s.value - exact.lag_s() : 0.0;
  plant.uncertainty.longer_s = {plant.late_s.lo - plant.late_s.value + longer_s,
                                plant.late_s.hi - plant.late_s.value + longer_s};
}

/// Sets the uncertainty of the plant if the record shows no mode. The interval of the delay comes from the
/// fit `found`. The interval of the resonance extends from the stated frequency to infinity, because the
/// record gives no upper limit.
void set_intervals(IdentifiedPlant& plant, const ChainRecord& chain, const Found& found,
                   const controller::Delays& stated) {
  const double error_s = chain.confidence(found).standard_error[late_cycles] * chain.cycle_s(),
               late_s = found.at[late_cycles] * chain.cycle_s(),
               reach_s = identification::two_sided_95 * error_s;
  plant.late_s = {late_s, error_s, late_s - reach_s, late_s + reach_s};
  plant.uncertainty = uncertainty_of(stated, chain.delays(found.at));
  plant.uncertainty.longer_s = {std::max(-reach_s, -late_s), reach_s};
}

/// Returns the standard error of one unknown of the chain at the point of the fit `found`. It is computed as
/// if all unknowns were free, because a fit with fixed unknowns gives too small errors. Returns 1 if the
/// error is larger or not finite.
double error_of(const ChainRecord& chain, const Found& found, ChainUnknown unknown) {
  // Makes all unknowns free: an unknown is free if its two bounds differ. How much they differ does not
  // change the standard error, which depends only on the derivatives at the fitted point.
  constexpr double half_width = 0.1;
  Found all = found;
  all.box.min() = found.at.array() - half_width;
  all.box.max() = found.at.array() + half_width;
  const double error = chain.confidence(all).standard_error[unknown];
  return std::isfinite(error) ? std::min(error, 1.0) : 1.0;
}

/// Returns the relative standard error of the resonance if the record shows no mode. The samples may contain
/// an image of the mode: a weak trace of it at a lower frequency. If the fit `found` used this image, the
/// error is computed from the fit. Otherwise, it is the error of a stated resonance, stated_mode_error.
double mode_error(const ChainRecord& chain, const Found& found) {
  // Smallest error that is returned. A mode above half the rate appears in the samples as an image at a lower
  // frequency. This image cannot show the frequency more exactly, because a slightly different frequency with
  // another damping gives almost the same image.
  constexpr double image = 0.005;
  const double cycles = std::exp(found.at[log_frequency]) * chain.cycle_s();
  if (found.box.min()[log_frequency] == found.box.max()[log_frequency] ||
      controller::rings_between_samples(cycles))
    return stated_mode_error;
  return std::clamp(error_of(chain, found, log_frequency), image, stated_mode_error);
}

}  // namespace

bool is_as_stated(const SecondOrderFit& shown, double stated_Hz) {
  return std::abs(shown.natural_frequency_Hz.value / stated_Hz - 1.0) <= 1.5 * stated_share;
}

IdentifiedPlant identified_plant(const Dataset& record, const controller::Delays& stated) {
  IdentifiedPlant plant;
  find_mode(plant, record);
  const ChainRecord chain(record, stated);
  const Found found = best_of(plant, chain, stated);
  const ChainPoint& at = found.at;
  const controller::Delays exact = chain.delays(at);
  if (plant.mode)
    set_intervals(plant, exact);
  else
    set_intervals(plant, chain, found, stated);
  plant.delays = exact;
  plant.delays.resonance_Hz = rounded(exact.resonance_Hz);
  plant.delays.damping_ratio = rounded(exact.damping_ratio);
  plant.delays.amplifier_bandwidth_Hz =
      keeps_lag(plant) ? stated.amplifier_bandwidth_Hz : rounded(exact.amplifier_bandwidth_Hz);
  plant.delays.sensor_delay = std::chrono::round<std::chrono::microseconds>(exact.sensor_delay);
  plant.pure_s = at[pure_share] * at[late_cycles] * chain.cycle_s();
  plant.share_error = error_of(chain, found, pure_share);
  plant.mode_error = plant.mode ? 0.0 : mode_error(chain, found);
  plant.gain = chain.gain(at);
  if (plant.gain < 0.0) throw identification::OutputFalls();
  plant.residual_rms = chain.residual_rms(at);
  plant.explained = chain.explained(at);
  plant.cycle_s = chain.cycle_s();
  plant.rows = record.size();
  plant.left_out = chain.cycles() - record.size();
  return plant;
}

}  // namespace hystcan::app
