#include "app/stage/cautious_excitation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <variant>
#include <vector>

#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "identification/characterisation.h"

namespace hystcan::app {
namespace {

using controller::Cause;
using controller::Excitation;
using model::Interval;

/// Returns a smaller excitation than `whole`: a single loop around the safe drive, over `share` of the drive
/// range of `whole`, with the same slew rate.
Excitation::Hysteresis part_of(const Excitation::Hysteresis& whole, double share, double safe_drive) {
  const double span = share * (whole.high - whole.low);
  Excitation::Hysteresis part = whole;
  part.low = std::min(std::max(safe_drive - span / 2.0, whole.low), whole.high - span);
  part.high = part.low + span;
  part.loops = 1;
  part.levels = 0;
  return part;
}

double covariance(const std::vector<double>& a, const std::vector<double>& b) {
  const auto mean = [](const std::vector<double>& of) {
    return std::reduce(of.begin(), of.end()) / static_cast<double>(of.size());
  };
  const double mean_a = mean(a), mean_b = mean(b);
  return std::transform_reduce(a.begin(), a.end(), b.begin(), 0.0, std::plus<>(),
                               [=](double x, double y) { return (x - mean_a) * (y - mean_b); });
}

/// Returns true if the position clearly falls when the drive rises.
bool falls(const std::vector<double>& drives, const std::vector<double>& positions_um) {
  // Correlation of drive and position below which the position clearly falls. The correlation is about 0 if
  // positive and negative drives move the actuator in the same direction, as in magnetostriction.
  constexpr double clear = -0.5;
  return covariance(drives, positions_um) <
         clear * std::sqrt(covariance(drives, drives) * covariance(positions_um, positions_um));
}

/// Drives the loop and returns the range of the positions; `nullopt` if the position exceeded a limit or
/// jumped. Throws RunError at any other fault, and if the position falls while the drive rises.
std::optional<Interval> positions_of(const config::Config& config, const twin::Config& twin,
                                     const OpenLoopOptions& run, const Excitation::Hysteresis& loop) {
  std::vector<double> drives, positions_um;
  const OpenLoopEnd end =
      drive_in_open_loop(in_open_loop(config, loop), twin, run, [&](const controller::CycleRecord& record) {
        if (!shows_position(record.report)) return;
        drives.push_back(record.report.drive);
        positions_um.push_back(record.report.position_um);
      });
  if (is_of_size(end.axis.fault())) {
    note("{}\n", describe(config.axes[0].wire.name, end.axis.fault()));
    return std::nullopt;
  }
  end.require_finished(config.axes[0].wire.name, "stopped during a small loop; nothing is written");
  if (falls(drives, positions_um))
    throw RunError(fmt::format("{}: {:g} to {:g} {}", config.axes[0].wire.name, loop.low, loop.high,
                               config.axes[0].wire.drive_unit),
                   identification::OutputFalls(), {.remedy = "nothing is written"});
  const auto [low_um, high_um] = std::ranges::minmax(positions_um);
  note("small loop, {:g} to {:g} {}: position {:.4g} to {:.4g} um\n", loop.low, loop.high,
       config.axes[0].wire.drive_unit, low_um, high_um);
  return Interval{low_um, high_um};
}

/// Extrapolates a measured loop linearly. Returns the range of the drive in which the position should stay
/// within its limits. `measured`: range of the positions in the loop.
Interval drives_within(const Excitation::Hysteresis& loop, const Interval& measured,
                       const controller::Supervisor::Config& limits) {
  const double per_um = (loop.high - loop.low) / measured.span();
  return {loop.low - per_um * (measured.lo - limits.position_min_um),
          loop.high + per_um * (limits.position_max_um - measured.hi)};
}

/// Extrapolates from a small loop to the excitation `whole`, which has a larger drive range. `measured`:
/// range of the positions in the small loop. Returns `whole` with a smaller drive range that should keep the
/// position within its limits; `nullopt` if the full range should keep them.
std::optional<Excitation::Hysteresis> part_within_limits(const Excitation::Hysteresis& whole,
                                                         const Excitation::Hysteresis& loop,
                                                         const Interval& measured,
                                                         const controller::Supervisor::Config& limits) {
  // Hysteresis curves are not straight, so the extrapolated drive range `fit` is inexact. The full range is
  // allowed if each of its ends exceeds `fit` by at most the share `doubtful` of the full range. Otherwise,
  // each end of the new range is at the share `kept` of the way from the small loop to `fit`.
  constexpr double doubtful = 0.2, kept = 0.7;
  const Interval fit = drives_within(loop, measured, limits);
  const double slack = doubtful * (whole.high - whole.low);
  if (fit.lo <= whole.low + slack && fit.hi >= whole.high - slack) return std::nullopt;
  Excitation::Hysteresis smaller = whole;
  smaller.low = std::max(whole.low, loop.low + kept * (fit.lo - loop.low));
  smaller.high = std::min(whole.high, loop.high + kept * (fit.hi - loop.high));
  return smaller;
}

constexpr double amplitude_margin = 2.0;

double amplitude_of(const Excitation::Config& excitation) {
  if (const auto* steps = std::get_if<Excitation::Steps>(&excitation)) return steps->amplitude;
  return std::get<Excitation::Chirp>(excitation).amplitude;
}

/// Returns the reason why this excitation is too large, from a rehearsal with the twin; `nullopt` if the
/// excitation is not too large.
std::optional<std::string> excess_of(const config::Config& config, const twin::Config& twin,
                                     const Excitation::Config& excitation) {
  const controller::Supervisor::Config& limits = config.axes[0].control.supervision;
  OpenLoopOptions rehearsed;
  rehearsed.rehearse = true;
  std::vector<double> positions_um;
  try {
    const OpenLoopEnd end = drive_in_open_loop(in_open_loop(config, excitation), twin, rehearsed,
                                               [&](const controller::CycleRecord& record) {
                                                 if (shows_position(record.report))
                                                   positions_um.push_back(record.report.position_um);
                                               });
    if (stop_signalled != 0) throw RunError("stopped before the experiment; nothing is written");
    if (end.axis.fault().cause != Cause::none) return describe(config.axes[0].wire.name, end.axis.fault());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  if (positions_um.empty()) return "no sample arrived";
  double jump_um = 0.0;
  for (std::size_t i = 1; i < positions_um.size(); ++i)
    jump_um = std::max(jump_um, std::abs(positions_um[i] - positions_um[i - 1]));
  if (limits.position_jump_um > 0.0 && amplitude_margin * jump_um > limits.position_jump_um)
    return fmt::format("the position moves by {:.3g} um between samples, position_jump_um is {:g}", jump_um,
                       limits.position_jump_um);
  const double first_um = positions_um.front();
  const Interval measured{std::ranges::min(positions_um), std::ranges::max(positions_um)};
  const auto extrapolated_um = [&](double um) { return first_um + amplitude_margin * (um - first_um); };
  if (extrapolated_um(measured.lo) < limits.position_min_um ||
      extrapolated_um(measured.hi) > limits.position_max_um)
    return fmt::format(
        "the position moves from {:.4g} to {:.4g} um, "
        "position_min_um and position_max_um are {:g} and {:g}",
        measured.lo, measured.hi, limits.position_min_um, limits.position_max_um);
  return std::nullopt;
}

}  // namespace

double quasi_static_period_s(double resonance_Hz) { return std::max(2.0, 100.0 / resonance_Hz); }

Excitation::Config resized(Excitation::Config excitation, double factor, double safe_drive) {
  if (auto* loops = std::get_if<Excitation::Hysteresis>(&excitation)) {
    const double about = std::clamp(safe_drive, loops->low, loops->high);
    loops->low = about + factor * (loops->low - about);
    loops->high = about + factor * (loops->high - about);
  } else if (auto* steps = std::get_if<Excitation::Steps>(&excitation)) {
    steps->amplitude *= factor;
  } else if (auto* chirp = std::get_if<Excitation::Chirp>(&excitation)) {
    chirp->amplitude *= factor;
  }
  return excitation;
}

Excitation::Config with_margin(const config::Config& config, const twin::Config& twin,
                               const Excitation::Config& whole) {
  const double safe_drive = config.axes[0].control.gate.safe_drive;
  constexpr int most_halvings = 8;
  const double amplitude = amplitude_of(whole);
  std::string excess;
  for (int halvings = 0; halvings <= most_halvings; ++halvings) {
    const double factor = std::ldexp(1.0, -halvings);
    const Excitation::Config part = resized(whole, factor, safe_drive);
    const auto found = excess_of(config, twin, part);
    if (!found && halvings > 0)
      note("amplitude {:g} {} instead of {:g}: a larger amplitude brings the twin near a limit\n",
           factor * amplitude, config.axes[0].wire.drive_unit, amplitude);
    if (!found) return part;
    excess = *found;
  }
  throw RunError(fmt::format(
      "the experiment is too large for the twin, even with an amplitude of {:.3g}: "
      "{}; check [axis.twin] and the limits of [axis.control], or set --amplitude. Nothing is written",
      std::ldexp(amplitude, -most_halvings), excess));
}

bool is_of_size(const controller::Fault& fault) {
  return fault.cause == Cause::position_implausible || fault.cause == Cause::position_jumped;
}

Excitation::Hysteresis tried_small_first(const config::Config& config, const twin::Config& twin,
                                         const OpenLoopOptions& run, const Excitation::Hysteresis& whole) {
  const controller::AxisConfig& control = config.axes[0].control;
  const std::string& unit = config.axes[0].wire.drive_unit;
  for (const double share : {0.1, 0.3}) {
    const Excitation::Hysteresis part = part_of(whole, share, control.gate.safe_drive);
    const auto measured = positions_of(config, twin, run, part);
    if (!measured)
      throw RunError(fmt::format(
          "a drive of {:g} to {:g} {} already moves the position beyond "
          "position_min_um, position_max_um or position_jump_um; "
          "check these limits, and the sign, zero (`hystcan init --sensor-at-safe`) and unit of the sensor. "
          "Nothing is written",
          part.low, part.high, unit));
    if (const auto smaller = part_within_limits(whole, part, *measured, control.supervision)) {
      const controller::Supervisor::Config& limits = control.supervision;
      note(
          "drive {:.4g} to {:.4g} {} instead of {:g} to {:g}: "
          "a larger range moves the position out of its limits, {:g} to {:g} um, "
          "because the sensor reads about {:.3g} um at {:g} {}. "
          "If this reading is correct, create the stage with this reading: `hystcan init --sensor-at-safe`\n",
          smaller->low, smaller->high, unit, whole.low, whole.high, limits.position_min_um,
          limits.position_max_um, 0.5 * (measured->lo + measured->hi), control.gate.safe_drive, unit);
      return *smaller;
    }
  }
  return whole;
}

}  // namespace hystcan::app
