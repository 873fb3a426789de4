#include "controller/control/gate.h"

#include <algorithm>
#include <cmath>

namespace hystcan::controller {

std::string limits_to_string(std::uint8_t limits) {
  static constexpr std::pair<std::uint8_t, const char*> names[] = {{limit::range, "range"},
                                                                   {limit::slew, "slew"},
                                                                   {limit::not_finite, "not_finite"},
                                                                   {limit::model, "model"},
                                                                   {limit::not_invertible, "not_invertible"}};
  std::string text;
  for (const auto& [bit, name] : names) {
    if ((limits & bit) == 0) continue;
    if (!text.empty()) text += '+';
    text += name;
  }
  return text;
}

Gate::Passed Gate::step(const Config& config, double last, double requested, double dt_s) {
  if (!std::isfinite(last)) return {.drive = config.safe_drive, .limits = limit::not_finite};
  Passed passed{.drive = std::clamp(last, config.drive_min, config.drive_max)};
  if (!std::isfinite(requested) || !std::isfinite(dt_s)) {
    passed.limits = limit::not_finite;
    return passed;
  }
  const double in_range = std::clamp(requested, config.drive_min, config.drive_max);
  if (in_range != requested) passed.limits |= limit::range;
  const double reach = config.slew_per_s * std::max(dt_s, 0.0);
  const double reachable = std::clamp(in_range, passed.drive - reach, passed.drive + reach);
  if (reachable != in_range) passed.limits |= limit::slew;
  // The last check also rejects a NaN from the calculation above: with NaN, the comparison is false.
  if (!(reachable >= config.drive_min && reachable <= config.drive_max))
    return {.drive = config.safe_drive, .limits = limit::not_finite};
  passed.drive = reachable;
  return passed;
}

bool Gate::approach(const Config& config, double& drive, double target, double reach, double dt_s) {
  drive = step(config, drive, std::clamp(target, drive - reach, drive + reach), dt_s).drive;
  return drive == std::clamp(target, config.drive_min, config.drive_max);
}

}  // namespace hystcan::controller
