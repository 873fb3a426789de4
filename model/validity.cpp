#include "model/validity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <utility>

namespace hystcan::model {
namespace {

constexpr std::size_t fine = 200;  // number of grid steps over the input range in a check
// Limits for a convergence rate k times the span of the input. At the lowest value, e^{-k d} is at most
// e^300, far from overflow. The search for the largest valid k ends at the highest value.
constexpr double lowest_k_span = -300.0;
constexpr double highest_k_span = 1e5;

// Joins texts and numbers into a message. Numbers have six digits.
template <typename... Parts>
std::string message_of(const Parts&... parts) {
  std::ostringstream text;
  text.precision(6);
  (text << ... << parts);
  return text.str();
}

template <typename... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  throw std::invalid_argument(message_of(parts...));
}

const char* name_of_k(Direction direction) {
  return direction == Direction::ascending ? "k_ascending" : "k_descending";
}

struct Units {
  std::string input, slope;
  explicit Units(const HysteresisParameters& p)
      : input(p.input_unit), slope(p.output_unit + "/" + p.input_unit) {}
};

void check_ranges(const HysteresisParameters& p) {
  const Interval a = p.ascending.domain(), d = p.descending.domain();
  if (a.lo != d.lo || a.hi != d.hi)
    refuse("ascending curve on [", a.lo, ", ", a.hi, "], descending curve on [", d.lo, ", ", d.hi,
           "], expected the same interval");
  if (p.ascending.knots() != p.descending.knots())
    refuse("ascending curve with ", p.ascending.knots().size(), " knots, descending curve with ",
           p.descending.knots().size(), ", expected the same knots");
  if (p.symmetry == Symmetry::even && a.lo < 0.0)
    refuse("interval starts at ", a.lo, " ", p.input_unit, ", expected 0 or more if symmetry is even");
  check_input_map(p);
  const double span = p.place(a.hi) - p.place(a.lo);
  const auto check_k = [&](const char* name, double k) {
    if (!std::isfinite(k) || k * span < lowest_k_span)
      refuse(name, " = ", k, " 1/", p.input_unit, ", expected a number of at least ", lowest_k_span / span);
  };
  check_k("k_ascending", p.k_ascending);
  check_k("k_descending", p.k_descending);
}

// Checks that a curve increases. A slope of zero at one point is accepted, because a butterfly is flat at the
// origin and rounding hides its rise there. A curve that is flat over a twentieth of the range is refused.
void check_increasing(const ReferenceCurve& curve, const char* name, const Units& units) {
  constexpr std::size_t points = 2000;
  const Interval& range = curve.domain();
  const std::vector<double> grid = grid_of(range, curve.knots(), points);
  const auto at = [&](std::size_t i) { return grid[i]; };
  const double mean = (curve.value(range.hi) - curve.value(range.lo)) / range.span();
  if (!(mean > 0.0))
    refuse(name, " curve runs from ", curve.value(range.lo), " to ", curve.value(range.hi), " between ",
           range.lo, " and ", range.hi, " ", units.input, " (mean slope ", mean, " ", units.slope,
           "), expected an increasing curve");
  constexpr std::size_t flat = points / 20;
  for (std::size_t i = 0; i <= points; ++i) {
    const double tolerance = 1e-10 * mean;
    const bool rises = i < flat || curve.value(at(i)) > curve.value(at(i - flat));
    if (curve.slope(at(i)) >= -tolerance && rises) continue;
    double lowest = curve.slope(at(i));
    std::size_t last = i;
    while (last < points && curve.slope(at(last + 1)) < -tolerance)
      lowest = std::min(lowest, curve.slope(at(++last)));
    refuse(name, " curve decreases between ", at(i), " and ", at(std::max(last, std::min(points, i + 1))),
           " ", units.input, " (slope ", lowest, " ", units.slope, "), expected an increasing curve");
  }
}

// Returns the rounding error of a curve at a point where the curve has the value `level`. If the values of a
// curve are far from zero, this error exceeds a tolerance that is a share of the curve's span.
double rounding_of(double level) { return 8.0 * std::numeric_limits<double>::epsilon() * std::abs(level); }

void check_meeting(const HysteresisParameters& p) {
  const Interval& range = p.ascending.domain();
  const double highest = p.ascending.value(range.hi), lowest = p.ascending.value(range.lo);
  const double tolerance = 1e-9 * (highest - lowest) + rounding_of(highest);
  const double gap = p.descending.value(range.hi) - p.ascending.value(range.hi);
  if (std::abs(gap) > tolerance)
    refuse("descending curve is ", gap, " ", p.output_unit, " above the ascending curve at ", range.hi, " ",
           p.input_unit, ", expected the curves to meet there within ", tolerance);
  if (p.descending.value(range.lo) >= p.ascending.value(range.hi))
    refuse("descending curve at the lower threshold is ", p.descending.value(range.lo), " ", p.output_unit,
           ", expected less than the output ", p.ascending.value(range.hi), " at the upper threshold");
  const auto below = [&](double v) { return p.descending.value(v) - p.ascending.value(v) < -tolerance; };
  for (const double v : grid_of(range, p.ascending.knots(), 10 * fine))
    if (below(v))
      refuse("descending curve is ", p.ascending.value(v) - p.descending.value(v), " ", p.output_unit,
             " below the ascending curve at ", v, " ", p.input_unit,
             ", expected a descending curve above the ascending one (the loops may be clockwise)");
}

void check_output_map(const HysteresisParameters& p) {
  if (!p.output_map) return;
  const Interval& inner = p.output_map->inner();
  const Interval levels{std::min(p.lower_point().level, p.ascending.value(p.input_range().lo)),
                        p.upper_point().level};
  const double tolerance = 1e-9 * levels.span();
  if (inner.lo > levels.lo + tolerance || std::abs(inner.hi - levels.hi) > tolerance)
    refuse("output map covers ", inner.lo, " to ", inner.hi, ", expected the range of the curves, ",
           levels.lo, " to ", levels.hi);
  if (p.symmetry == Symmetry::even)
    refuse("symmetry is even and the model has an output map, expected only one of the two");
}

// One reference curve on a grid of inputs, with the numbers that advance a branch from one grid point to the
// next. The grid begins at the threshold where Scan begins. The outputs in `value` rise along the grid.
struct Grid {
  std::vector<double> input, value;
  std::vector<double> slope;  // slope of the curve, output units per unit of the input map h
  // For each grid point: e^{-k s} and phi(s) = (1 - e^{-k s}) / k, with the distance s from the previous grid
  // point and the convergence rate k.
  std::vector<double> decay, phi;
};

// The numbers e^{-k d} and phi(d) = (1 - e^{-k d}) / k of a branch (k: convergence rate), at the distance d
// from the start of the branch. They are updated from grid point to grid point, because a new exponential at
// every point of every branch would be slow.
struct Along {
  double decay = 1.0, phi = 0.0;

  void pass(const Grid& grid, std::size_t step) {
    // phi(d + s) = phi(d) + e^{-k d} phi(s), with the distance d before and the step s to the next point.
    phi += decay * grid.phi[step];
    decay *= grid.decay[step];
  }
};

// Returns the grid of the reference curve of one direction. `seen` is ascending for the scan from the lower
// threshold, and descending for the scan from the upper threshold. In the second case, the grid reverses both
// axes, so that falling branches rise. The same scan therefore works from both thresholds.
Grid grid_of(const HysteresisParameters& p, Direction direction, Direction seen, std::size_t steps) {
  Grid grid;
  const ReferenceCurve& curve = p.curve(direction);
  const Interval& range = curve.domain();
  const double k = p.k(direction);
  // If k is this small, the branch converges linearly: phi(d) equals d to rounding (phi: model/hysteresis.h).
  const bool straight = std::abs(k) * (p.place(range.hi) - p.place(range.lo)) <= 1e-17;
  grid.input = grid_of(range, curve.knots(), steps);
  if (seen == Direction::descending) std::ranges::reverse(grid.input);
  double before = p.place(grid.input.front());
  for (const double v : grid.input) {
    const double here = p.place(v), step = std::abs(here - before);
    before = here;
    grid.value.push_back(sign(seen) * curve.value(v));
    grid.slope.push_back(curve.slope(v) / p.stretch(v));
    grid.decay.push_back(std::exp(-k * step));
    grid.phi.push_back(straight ? step : -std::expm1(-k * step) / k);
  }
  return grid;
}

// Scans the slopes of three kinds of branches: the branch from one threshold, the branches in the opposite
// direction that leave it, and the branches that turn back from those. Inside the scan, the branch from the
// threshold always rises.
class Scan {
 public:
  Scan(const HysteresisParameters& p, Direction rising_way, std::size_t steps)
      : way_(rising_way),
        steps_(steps),
        rise_(grid_of(p, true_direction(true), rising_way, steps)),
        fall_(grid_of(p, true_direction(false), rising_way, steps)) {
    const double span = p.ascending.domain().span();
    tolerance_ = 1e-9 *
                 (p.ascending.value(p.ascending.domain().hi) - p.descending.value(p.ascending.domain().lo)) /
                 span;
  }

  /// Calls `found` with each decreasing branch, until `found` returns true. The candidates are the branch
  /// from the threshold, the falling branch from each grid point, and the rising branches from each grid
  /// point. Each rising branch has a coefficient S (model/hysteresis.h) and a limit, the largest S with which
  /// it still increases. Of the rising branches from one grid point, only the branch with the largest S minus
  /// limit is a candidate.
  template <class OnFound>
  void run(OnFound found) const {
    const double gap = fall_.value[0] - rise_.value[0];
    // The numbers e^{-k d} and phi(d) at each grid point, with the distance d from the threshold. `rising`
    // belongs to the branch that rises from the threshold, and `fallen` to the falling branches that end at
    // the threshold.
    std::vector<Along> rising(steps_ + 1), fallen(steps_ + 1);
    for (std::size_t i = 1; i <= steps_; ++i) {
      (rising[i] = rising[i - 1]).pass(rise_, i);
      (fallen[i] = fallen[i - 1]).pass(fall_, i);
    }
    const double first = gap / rising[steps_].phi;
    if (const auto branch = find_on_branch(true, 0, steps_, first); branch && found(*branch)) return;
    std::vector<double> outer(steps_ + 1), falling(steps_ + 1, 0.0), distance(steps_ + 1, 0.0);
    for (std::size_t i = 0; i <= steps_; ++i) outer[i] = rise_.value[i] + gap - first * rising[i].phi;
    for (std::size_t u = 1; u <= steps_; ++u) {
      distance[u] = fall_.value[u] - outer[u];
      falling[u] = distance[u] / fallen[u].phi;
      if (const auto branch = find_on_branch(false, u, 0, falling[u]); branch && found(*branch)) return;
    }
    for (std::size_t l = 1; l < steps_; ++l) {
      // The numbers e^{-k d} and phi(d) at the ends of two branches: `up` rises from grid point l to grid
      // point u, and `down` falls from u to l.
      Along up, down;
      double limit = coefficient_limit(l, up), farthest = 0.0, steepest = 0.0;
      std::size_t target = 0;
      for (std::size_t u = l + 1; u <= steps_; ++u) {
        up.pass(rise_, u);
        down.pass(fall_, u);
        limit = std::min(limit, coefficient_limit(u, up));
        const double output = fall_.value[l] - distance[u] + falling[u] * down.phi;
        const double coefficient = first * rising[l].decay + (output - outer[l]) / up.phi;
        if (coefficient - limit <= farthest) continue;
        farthest = coefficient - limit;
        steepest = coefficient;
        target = u;
      }
      if (target == 0) continue;
      if (const auto branch = find_on_branch(true, l, target, steepest); branch && found(*branch)) return;
    }
  }

 private:
  // Returns the largest coefficient S at the start of a branch with which the branch still increases at grid
  // point i.
  double coefficient_limit(std::size_t i, const Along& from_its_start) const {
    return std::max(rise_.slope[i] + tolerance_, 0.0) / from_its_start.decay;
  }

  // Returns the direction that a branch has in the model. A scan from the upper threshold reverses the input
  // and the output, so that the same code scans from both thresholds. A branch that rises in this scan falls
  // in the model.
  Direction true_direction(bool rising) const { return rising ? way_ : opposite(way_); }
  double input(std::size_t i) const { return rise_.input[i]; }

  std::optional<DecreasingBranch> find_on_branch(bool rising, std::size_t from, std::size_t to,
                                                 double coefficient) const {
    const Grid& grid = rising ? rise_ : fall_;
    const std::size_t length = rising ? to - from : from - to;
    double lowest = 0.0;
    std::size_t first = 0, last = 0, lowest_at = 0;
    Along course;
    for (std::size_t j = 0; j <= length; ++j) {
      const std::size_t at = rising ? from + j : from - j;
      if (j > 0) course.pass(grid, rising ? at : at + 1);
      const double slope = grid.slope[at] - coefficient * course.decay;
      if (slope >= -tolerance_) continue;
      if (lowest == 0.0) first = j;
      last = j;
      if (slope < lowest) lowest_at = j;
      lowest = std::min(lowest, slope);
    }
    if (lowest == 0.0) return std::nullopt;
    const auto place = [&](std::size_t j) { return input(rising ? from + j : from - j); };
    return DecreasingBranch{true_direction(rising),
                            input(from),
                            input(to),
                            {std::min(place(first), place(last)), std::max(place(first), place(last))},
                            lowest,
                            place(lowest_at)};
  }

  Direction way_;
  std::size_t steps_;
  Grid rise_, fall_;
  double tolerance_ = 0.0;
};

HysteresisParameters with_k(HysteresisParameters parameters, Direction direction, double k) {
  (direction == Direction::ascending ? parameters.k_ascending : parameters.k_descending) = k;
  return parameters;
}

HysteresisParameters with_both_k_times(HysteresisParameters parameters, double factor) {
  parameters.k_ascending *= factor;
  parameters.k_descending *= factor;
  return parameters;
}

// Searches between `good` and `bad` for the limit up to which `make(value)` is a model without a decreasing
// branch. make(good) must be such a model. Returns `bad` if make(bad) is such a model too. Otherwise returns
// a value before the limit, at such a distance that it stays valid when written with six digits.
template <class Make>
double last_good(Make make, double good, double bad) {
  if (!find_decreasing_branch(make(bad))) return bad;
  const double near_enough = 1e-9 * std::abs(bad - good);
  while (std::abs(bad - good) > near_enough) {
    const double middle = good + (bad - good) / 2.0;
    (find_decreasing_branch(make(middle)) ? bad : good) = middle;
  }
  return good - std::copysign(1e-5 * std::abs(good), bad - good);
}

// Returns the end of the error message: which k would be valid with these curves.
std::string remedy(const HysteresisParameters& parameters, Direction direction) {
  const double k = parameters.k(direction);
  const std::string in_use = message_of(name_of_k(direction), " = ", k, " 1/", parameters.input_unit);
  const auto allowed = allowed_k(parameters, direction);
  if (allowed && k > allowed->hi)
    return message_of(in_use, " is too large, at most ", allowed->hi, " is valid");
  if (allowed && k < allowed->lo)
    return message_of(in_use, " is too small, at least ", allowed->lo, " is valid");
  const auto scaled = [&](double factor) { return with_both_k_times(parameters, factor); };
  if (k <= 0.0 || find_decreasing_branch(scaled(0.0)))
    return message_of(
        in_use, " is not the cause; the two curves are too far apart at the inputs with the negative slope");
  const HysteresisParameters good = scaled(last_good(scaled, 0.0, 1.0));
  return message_of(in_use, " is too large together with ", name_of_k(opposite(direction)),
                    "; valid values are k_ascending = ", good.k_ascending,
                    " and k_descending = ", good.k_descending);
}

}  // namespace

void check_input_map(const HysteresisParameters& parameters) {
  if (parameters.input_map &&
      !std::ranges::is_sorted(parameters.input_map->coefficients(), std::less_equal{}))
    throw std::invalid_argument("input_map is not increasing, expected increasing coefficients");
}

void check_curves(const HysteresisParameters& parameters) {
  check_ranges(parameters);
  const Units units(parameters);
  check_increasing(parameters.ascending, "ascending", units);
  check_increasing(parameters.descending, "descending", units);
  check_meeting(parameters);
  check_output_map(parameters);
}

std::optional<DecreasingBranch> find_decreasing_branch(const HysteresisParameters& parameters) {
  std::optional<DecreasingBranch> found;
  const auto take = [&](const DecreasingBranch& branch) {
    found = branch;
    return true;
  };
  Scan(parameters, Direction::ascending, fine).run(take);
  if (!found) Scan(parameters, Direction::descending, fine).run(take);
  return found;
}

std::vector<DecreasingBranch> find_decreasing_branches(const HysteresisParameters& parameters,
                                                       std::size_t steps) {
  constexpr double blocks = 10.0;
  std::vector<DecreasingBranch> worst;
  const Interval& range = parameters.input_range();
  const auto block = [&](const DecreasingBranch& branch) {
    return std::pair(branch.direction, std::floor(blocks * (branch.start - range.lo) / range.span()));
  };
  const auto gather = [&](const DecreasingBranch& branch) {
    if (worst.empty() || block(worst.back()) != block(branch))
      worst.push_back(branch);
    else if (branch.slope < worst.back().slope)
      worst.back() = branch;
    return false;
  };
  Scan(parameters, Direction::ascending, steps).run(gather);
  Scan(parameters, Direction::descending, steps).run(gather);
  return worst;
}

std::optional<Interval> allowed_k(const HysteresisParameters& parameters, Direction direction) {
  const double span =
      parameters.place(parameters.input_range().hi) - parameters.place(parameters.input_range().lo);
  double inside = parameters.k(direction);
  if (find_decreasing_branch(parameters)) {
    inside = 0.0;
    if (find_decreasing_branch(with_k(parameters, direction, inside))) return std::nullopt;
  }
  const auto with = [&](double other) { return with_k(parameters, direction, other); };
  return Interval{last_good(with, inside, lowest_k_span / span),
                  last_good(with, inside, highest_k_span / span)};
}

void check_branches(const HysteresisParameters& parameters) {
  const auto found = find_decreasing_branch(parameters);
  if (!found) return;
  const Units units(parameters);
  const auto& [lo, hi] = found->wrong;
  const std::string where = lo == hi ? message_of("at ", lo) : message_of("between ", lo, " and ", hi);
  throw BranchError(
      found->direction,
      message_of(found->direction == Direction::ascending ? "ascending" : "descending", " branch from ",
                 found->start, " towards ", found->target, " ", units.input, " has a negative slope ", where,
                 " ", units.input, " (slope ", found->slope * parameters.stretch(found->input), " ",
                 units.slope, "), expected an increasing branch: ", remedy(parameters, found->direction)));
}

}  // namespace hystcan::model
