#include "app/stage/safe_amplitude.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>

#include "app/live/report.h"
#include "app/live/stop_signal.h"
#include "app/stage/open_loop.h"
#include "app/stage/travel.h"
#include "base/error.h"

namespace hystcan::app {
namespace {

constexpr double margin = 2.0;

/// Why this excitation is too large; empty if it is not.
std::string excess_of(const config::Config& config, const twin::Config& twin,
                      const controller::Excitation::Config& excitation) {
  const controller::Supervisor::Config& limits = config.axes[0].control.supervision;
  OpenLoopOptions rehearsed;
  rehearsed.rehearse = true;
  Travel travel;
  try {
    const OpenLoopEnd end =
        drive_in_open_loop(in_open_loop(config, excitation), twin, rehearsed,
                           [&](const controller::CycleRecord& record) { travel.add(record.report); });
    if (stop_signalled != 0) throw RunError("stopped before the experiment, nothing is written");
    if (end.axis.fault().cause != controller::Cause::none)
      return describe(config.axes[0].wire.name, end.axis.fault());
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  if (limits.position_jump_um > 0.0 && margin * travel.largest_jump_um > limits.position_jump_um)
    return fmt::format("{:.3g} um from sample to sample, position_jump_um is {:g}", travel.largest_jump_um,
                       limits.position_jump_um);
  const auto twice = [&](double um) { return travel.first_um + margin * (um - travel.first_um); };
  if (twice(travel.low_um) < limits.position_min_um || twice(travel.high_um) > limits.position_max_um)
    return fmt::format("{:.4g} to {:.4g} um, position_min_um and position_max_um are {:g} and {:g}",
                       travel.low_um, travel.high_um, limits.position_min_um, limits.position_max_um);
  return {};
}

}  // namespace

double amplitude_with_margin(const config::Config& config, const twin::Config& twin, double amplitude,
                             const std::function<controller::Excitation::Config(double)>& excitation) {
  constexpr int halvings = 8;
  std::string excess;
  for (int i = 0; i <= halvings; ++i, amplitude /= 2.0) {
    excess = excess_of(config, twin, excitation(amplitude));
    if (excess.empty()) return amplitude;
  }
  throw RunError(fmt::format(
      "the experiment is too large for the twin even with an amplitude of {:.3g}: {}; nothing is written. "
      "Look at [axis.twin] and at the limits of [axis.control], or state an --amplitude",
      2.0 * amplitude, excess));
}

}  // namespace hystcan::app
