#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "app/stage/first_stage.h"
#include "identification/separable_fit.h"
#include "model/hysteresis_parameters.h"
#include "model/validity.h"

namespace hystcan::app {
namespace {

using model::Basis;
using model::Direction;
using model::HysteresisParameters;
using model::Interval;
using model::OutputCreep;
using model::ReferenceCurve;

constexpr double share_of_k = 20.0 / 3.0;

/// Returns the curve a s^2 + b s + c, where s grows from 0 to 1 over the domain. A Chebyshev basis uses t
/// from -1 to 1 instead: s = (1 + t) / 2 and s^2 = 3/8 + t/2 + T_2(t)/8, with the Chebyshev polynomial T_2.
ReferenceCurve parabola(double a, double b, double c, Interval domain) {
  return {Basis::chebyshev, {c + b / 2.0 + 3.0 * a / 8.0, b / 2.0 + a / 2.0, a / 8.0}, domain};
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

/// Changes a curve by `share`. All coefficients of a spline grow by this share. In a polynomial, all
/// coefficients except the first grow by this share; with `alternating`, those with an even index shrink, so
/// that the shape changes.
ReferenceCurve off_by(const ReferenceCurve& curve, double share, bool alternating) {
  std::vector<double> c = curve.coefficients();
  for (std::size_t j = 1; j < c.size(); ++j) c[j] *= alternating && j % 2 == 0 ? 1.0 - share : 1.0 + share;
  if (curve.basis() == Basis::spline) c = scaled(curve.coefficients(), 1.0 + share);
  return curve.with(c);
}

double farthest_apart(const ReferenceCurve& a, const ReferenceCurve& b) {
  double farthest = 0.0;
  for (const double v : model::grid_of(a.domain(), {}, 200))
    farthest = std::max(farthest, std::abs(a.value(v) - b.value(v)));
  return farthest;
}

/// Moves the curve towards `other` until it has moved by `distance` at the point where it moves most.
ReferenceCurve moved(const ReferenceCurve& curve, const ReferenceCurve& other, double distance) {
  const double whole = farthest_apart(curve, other);
  if (!(whole > 0.0)) return curve;
  std::vector<double> c = curve.coefficients();
  for (std::size_t j = 0; j < c.size(); ++j)
    c[j] += distance / whole * (other.coefficients()[j] - curve.coefficients()[j]);
  return curve.with(c);
}

/// Moves the ascending curve by `share` of half the output range, and makes the loop wider by the factor 1 +
/// `share`. With `alternating`, the curve also changes its shape (see off_by()).
HysteresisParameters with_curves_off(const HysteresisParameters& given, double share, bool alternating) {
  HysteresisParameters p = given;
  if (p.output_map) {  // the map converts the curves to outputs; it is changed instead of the curves
    std::vector<double> map = p.output_map->coefficients();
    for (std::size_t j = 1; j < map.size(); ++j) map[j] *= 1.0 + share;
    p.output_map.emplace(map, p.output_map->inner());
    return p;
  }
  p.ascending = moved(given.ascending, off_by(given.ascending, share, alternating),
                      share * 0.5 * given.output_range().span());
  std::vector<double> descending = p.ascending.coefficients();
  const std::vector<double>&rising = given.ascending.coefficients(),
        &falling = given.descending.coefficients();
  descending.resize(std::max(descending.size(), falling.size()));
  for (std::size_t j = 0; j < descending.size(); ++j)
    descending[j] +=
        (1.0 + share) * ((j < falling.size() ? falling[j] : 0.0) - (j < rising.size() ? rising[j] : 0.0));
  p.descending = given.descending.with(descending);
  return p;
}

/// Multiplies a convergence rate of the model (k_ascending or k_descending) by `factor`. Limits it to the
/// range in which every branch of the model increases.
void move_k(HysteresisParameters& p, Direction direction, double factor) {
  double& k = direction == Direction::ascending ? p.k_ascending : p.k_descending;
  if (const auto allowed = model::allowed_k(p, direction))
    k = std::clamp(k * factor, allowed->lo, allowed->hi);
}

std::optional<HysteresisParameters> valid(HysteresisParameters p, double k_factor) {
  try {
    model::check_curves(p);
    for (const Direction direction : {Direction::ascending, Direction::descending})
      move_k(p, direction, k_factor);
    model::check_branches(p);
    return p;
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

}  // namespace

HysteresisParameters straight_line(const AxisFacts& axis) {
  const controller::Gate::Config& gate = axis.config.control.gate;
  return model::straight_line(axis.config.wire.drive_unit, "um", {gate.drive_min, gate.drive_max},
                              axis.travel_um);
}

HysteresisParameters usual_loop(const AxisFacts& axis) {
  HysteresisParameters p = straight_line(axis);
  const Interval drive = p.input_range();
  const double stroke = axis.travel_um.span(), lowest = axis.travel_um.lo;
  p.ascending = parabola(0.2 * stroke, 0.8 * stroke, lowest, drive);
  // The width of the loop is the stroke times (1 - s) (0.05 + 0.35 s); s goes from 0 to 1 over the drive
  // range.
  p.descending = parabola((0.2 - 0.35) * stroke, (0.8 + 0.3) * stroke, lowest + 0.05 * stroke, drive);
  p.k_ascending = p.k_descending = 4.0 / drive.span();
  return p;
}

HysteresisParameters not_quite(const HysteresisParameters& parameters, double share) {
  for (const bool alternating : {true, false})
    if (auto p = valid(with_curves_off(parameters, share, alternating), 1.0 + share_of_k * share)) return *p;
  return parameters;
}

std::optional<OutputCreep::Config> not_quite(std::optional<OutputCreep::Config> creep, double share) {
  if (creep)
    creep->per_decade =
        std::min(creep->per_decade * (1.0 + share_of_k * share), identification::most_creep_per_decade);
  return creep;
}

}  // namespace hystcan::app
