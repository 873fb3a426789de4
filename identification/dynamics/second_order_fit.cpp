#include "identification/dynamics/second_order_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "identification/dynamics/mode_response.h"
#include "identification/numerics/decompositions.h"
#include "identification/numerics/nonlinear_fit.h"
#include "model/reference_curve.h"

namespace hystcan::identification {
namespace {

using Point = ModePoint;
constexpr double normal_tolerance = 1e-15;

struct Box {
  Point lo, hi;
  Point clamped(const Point& point) const { return point.cwiseMax(lo).cwiseMin(hi); }
};

Box searched(const SampledDataset& dataset) {
  return {{std::log(0.3 / dataset.duration_s()), std::log(1e-4), -1.0},
          {std::log(largest_frequency_cycles / dataset.cycle_s), std::log(5.0), largest_delay_cycles}};
}

/// The best linear part (offset, drift, gain, free decays) of a fit, for a given frequency, damping ratio and
/// delay.
struct Projection {
  OrthonormalColumns columns;
  Eigen::VectorXd coefficients;
  Eigen::VectorXd residual;  ///< measured output minus fitted output
};

/// A dataset, with an object that computes the response of a mode to its inputs.
struct Task {
  explicit Task(SampledDataset sampled)
      : dataset(std::move(sampled)), response(dataset, largest_delay_cycles) {}
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  Projection project(const Point& point) const {
    OrthonormalColumns columns(response.columns(point));
    auto [coefficients, residual] = columns.solve(dataset.output);
    return {std::move(columns), std::move(coefficients), std::move(residual)};
  }
  /// Returns the derivatives of the residual by frequency, damping ratio and delay. The derivatives of the
  /// linear coefficients are neglected (Kaufman 1975).
  ModeResponse::Slope residual_slope(const Point& point, const Projection& at) const {
    ModeResponse::Slope slope = -response.slope(point, at.coefficients);
    at.columns.remove_from(slope);
    return slope;
  }

  SampledDataset dataset;
  ModeResponse response;
};

struct LocalMinimum {
  Point point;
  double sum_of_squares;
};

/// Finds a minimum of the sum of squares by Levenberg-Marquardt. Ends when a step is shorter than
/// `resolution`. A coordinate stays fixed if its two limits in `box` are equal.
LocalMinimum descend(const Task& task, const Box& box, const Point& start, double resolution) {
  Projection at = task.project(start);
  LocalMinimum best{start, at.residual.squaredNorm()};
  double damping = 1e-3;
  for (int iteration = 0; iteration < 60; ++iteration) {
    ModeResponse::Slope slope = task.residual_slope(best.point, at);
    for (int i = 0; i < 3; ++i)
      if (box.lo[i] == box.hi[i]) slope.col(i).setZero();
    const Eigen::Matrix3d curvature = slope.transpose() * slope;
    const Point downhill = -slope.transpose() * at.residual;
    double moved = 0.0;
    while (damping < 1e9) {
      Eigen::Matrix3d damped = curvature;
      damped.diagonal() = damped.diagonal() * (1.0 + damping) + Point::Constant(1e-300);
      const Point next = box.clamped(
          best.point + shortest_solution(damped, downhill, normal_tolerance).cwiseMax(-0.5).cwiseMin(0.5));
      Projection candidate = task.project(next);
      const double sum = candidate.residual.squaredNorm();
      if (!(sum < best.sum_of_squares)) {
        damping *= 10.0;
        continue;
      }
      moved = (next - best.point).cwiseAbs().maxCoeff();
      best = {next, sum};
      at = std::move(candidate);
      damping = std::max(damping / 30.0, 1e-12);
      break;
    }
    if (moved < resolution) break;
  }
  return best;
}

/// Returns the numbers lo, lo + step, lo + 2 step and so on, up to hi.
std::vector<double> steps(double lo, double hi, double step) {
  std::vector<double> values(static_cast<std::size_t>(std::max(0.0, std::floor((hi - lo) / step + 1e-9))) +
                             1);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = lo + static_cast<double>(i) * step;
  return values;
}

// Returns the points of a grid, the best one first. Here the linear part of the fit has only offset, drift
// and gain. A delay that is longer by whole cycles only shifts the response, so that a point of the grid
// costs only a few products of vectors.
std::vector<LocalMinimum> grid(const Task& task, const Box& box) {
  constexpr double frequency_ratio = 1.15;
  const SampledDataset& dataset = task.dataset;
  const Eigen::VectorXd output = without_line(dataset.time, dataset.output);
  // The columns are a constant, the time and the output, with one value per cycle. A cycle without a row has
  // 0 in each column, so that the cycle does not count.
  Eigen::MatrixXd against = Eigen::MatrixXd::Zero(dataset.length(), 3);
  against(dataset.cycles, 0).setConstant(1.0 / std::sqrt(static_cast<double>(dataset.rows())));
  against(dataset.cycles, 1) = dataset.time.normalized();
  against(dataset.cycles, 2) = output;
  const Eigen::ArrayXd has_row = (against.col(0).array() > 0.0).cast<double>();
  const auto left = [&](const Eigen::Ref<const Eigen::VectorXd>& x) {
    const Eigen::Vector3d products = against.transpose() * x;
    const double squared = (x.array().square() * has_row).sum();
    const double about_line = squared - products.head<2>().squaredNorm();
    const double along = products[2];
    return output.squaredNorm() - (about_line > 1e-12 * squared ? along * along / about_line : 0.0);
  };
  std::vector<LocalMinimum> places;
  for (const double log_f : steps(box.lo[0], box.hi[0], std::log(frequency_ratio)))
    for (const double zeta : {0.03, 0.2, 0.9})
      for (const double part : {0.0, 0.5}) {
        const Point earliest{log_f, std::log(zeta), part};
        const Eigen::VectorXd x = task.response.long_response(earliest);
        for (int cycles = -1; part + cycles <= box.hi[2]; ++cycles)
          places.push_back({earliest + cycles * Point::UnitZ(),
                            left(x.segment(largest_delay_cycles - cycles, dataset.length()))});
      }
  std::ranges::stable_sort(places, {}, &LocalMinimum::sum_of_squares);
  return places;
}

/// Returns the starts for the fit: a few of the best points of the grid, but no two points that are close
/// together.
std::vector<Point> starts(const Task& task, const Box& box) {
  constexpr std::size_t most = 6;
  std::vector<Point> chosen;
  for (const LocalMinimum& place : grid(task, box)) {
    const auto near = [&](const Point& other) {
      const Point apart = (place.point - other).cwiseAbs();
      return apart[0] < 0.3 && apart[2] < 1.1;
    };
    if (std::ranges::none_of(chosen, near)) chosen.push_back(place.point);
    if (chosen.size() == most) break;
  }
  return chosen;
}

// Returns points that give almost the same samples as `point`. The first kind is the same frequency f with
// another delay. The second kind is the mirror image of f at half the sampling rate, with another delay and
// the same decay per second: samples cannot distinguish f from this image.
std::vector<Point> similar_points(const Task& task, const Box& box, const Point& point) {
  // Delays within `reach` cycles of the delay of `point` are tried, `spacing` cycles apart.
  constexpr double reach = 1.5, spacing = 0.1;
  const double f = std::exp(point[0]);
  const double image = std::max(1.0 / task.dataset.cycle_s - f, std::exp(box.lo[0]));
  std::vector<Point> found;
  for (const double frequency_Hz : {f, image}) {
    if (std::log(frequency_Hz) > box.hi[0]) continue;
    double sum = std::numeric_limits<double>::infinity();
    bool falling = false;
    Point before = point;
    for (const double delay : steps(point[2] - reach, point[2] + reach, spacing)) {
      const Point candidate =
          box.clamped({std::log(frequency_Hz), point[1] + std::log(f / frequency_Hz), delay});
      const double next = task.project(candidate).residual.squaredNorm();
      if (falling && next > sum) found.push_back(before);
      falling = next < sum;
      sum = next;
      before = candidate;
    }
  }
  return found;
}

/// Returns all minima of the sum of squares that were found, the best one first.
std::vector<LocalMinimum> minima(const Task& task, const Box& box) {
  constexpr int most_refinements = 3;
  constexpr double coarse = 1e-6, fine = 1e-11;
  std::vector<LocalMinimum> found;
  for (const Point& start : starts(task, box)) found.push_back(descend(task, box, start, coarse));
  std::ranges::sort(found, {}, &LocalMinimum::sum_of_squares);
  for (int round = 0; round < most_refinements; ++round) {
    const double best = found.front().sum_of_squares;
    for (const Point& start : similar_points(task, box, found.front().point))
      found.push_back(descend(task, box, start, coarse));
    std::ranges::sort(found, {}, &LocalMinimum::sum_of_squares);
    if (found.front().sum_of_squares > 0.99 * best) break;
  }
  found.front() = descend(task, box, found.front().point, fine);
  return found;
}

// Computes standard errors from the derivatives of the driven response, without the free decays. A free decay
// can follow an oscillation in the noise. It would then seem to determine the frequency, although the drive
// does not excite the mode.
Confidence confidence_at(const Task& task, const Point& point, const Projection& at) {
  Eigen::MatrixXd sensitivity(task.dataset.rows(), 3 + at.coefficients.size());
  sensitivity.leftCols<3>() = task.response.driven_slope(point, at.coefficients);
  sensitivity.rightCols(at.coefficients.size()) = task.response.columns(point);
  return confidence_of(sensitivity, at.residual, 3);
}

/// Returns the dataset with an ideal output: the response of the best mode to the inputs, without noise.
SampledDataset only_driven(const Task& task, const Point& point, const Projection& at) {
  SampledDataset dataset = task.dataset;
  dataset.output = task.response.driven(point, at.coefficients);
  return dataset;
}

/// Returns how far one coordinate (frequency, damping ratio or delay) can move away from `point`. At each
/// distance, the two other coordinates are fitted to `response`, the ideal response of the mode at `point`.
/// Returns the first distance at which the sum of squares of this fit exceeds `as_good`. The distance starts
/// at longest / 256 and doubles from try to try; if no try exceeds `as_good`, returns `longest`.
double profile_reach(int coordinate, double longest, const Task& response, Box box, const Point& point,
                     double as_good) {
  constexpr int halvings = 8;
  constexpr double resolution = 1e-4;
  const Box searched = box;
  Point from = point;
  for (int halved = halvings; halved > 0; --halved) {
    const double way = std::ldexp(longest, -halved);
    from[coordinate] = point[coordinate] + way;
    from = searched.clamped(from);
    box.lo[coordinate] = box.hi[coordinate] = from[coordinate];
    const LocalMinimum best = descend(response, box, from, resolution);
    if (best.sum_of_squares > as_good) return way;
    from = best.point;
  }
  return longest;
}

// Returns the confidence interval of one coordinate. Usually it is +-1.96 standard errors. But if the natural
// frequency is near half the sampling rate, the samples depend only on the square of the difference of these
// two frequencies. The sensitivity to the natural frequency is then zero, and the standard error has no
// meaning. A wide interval is therefore limited by a search, profile_reach().
model::Interval around(int coordinate, const Box& box, const Task& response, const Point& point,
                       const Confidence& confidence) {
  constexpr double wide = 0.01;
  const double reach = two_sided_95 * confidence.standard_error[coordinate];
  if (reach < wide) return {point[coordinate] - reach, point[coordinate] + reach};
  const Point widest = box.hi - box.lo;
  const double longest = std::min(reach, widest[coordinate]);
  return {point[coordinate] + profile_reach(coordinate, -longest, response, box, point, confidence.as_good()),
          point[coordinate] + profile_reach(coordinate, longest, response, box, point, confidence.as_good())};
}

/// Returns the confidence interval of one coordinate: log of the frequency, log of the damping ratio, or
/// delay in cycles. It contains the best minimum and all equally good minima.
model::Interval interval_of(int coordinate, const Box& box, const Task& response,
                            const std::vector<LocalMinimum>& found, const Confidence& confidence) {
  model::Interval interval = around(coordinate, box, response, found.front().point, confidence);
  const double as_good = found.front().sum_of_squares + confidence.as_good();
  for (const LocalMinimum& other : found) {
    if (other.sum_of_squares > as_good) continue;
    interval.lo = std::min(interval.lo, other.point[coordinate]);
    interval.hi = std::max(interval.hi, other.point[coordinate]);
  }
  // Limits the interval to `box`, the range of the search. If the dataset does not determine the coordinate,
  // the interval is this whole range.
  return {std::max(interval.lo, box.lo[coordinate]), std::min(interval.hi, box.hi[coordinate])};
}

Estimate exponential(double log_value, double standard_error, const model::Interval& interval) {
  const double value = std::exp(log_value);
  return {value, value * standard_error, std::exp(interval.lo), std::exp(interval.hi)};
}

Estimate scaled(double scale, double value, double standard_error, const model::Interval& interval) {
  return {scale * value, std::abs(scale) * standard_error, scale * interval.lo, scale * interval.hi};
}

double in_three_digits(double value) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2.0);
  return unit < 1.0 ? std::round(value / unit) / std::round(1.0 / unit) : std::round(value / unit) * unit;
}

std::string range_of(const Estimate& estimate) {
  return text_of(in_three_digits(estimate.lo), " to ", in_three_digits(estimate.hi));
}

bool is_determined(const Estimate& estimate, double largest_ratio) {
  return estimate.hi < largest_ratio * estimate.lo;  // also false if a limit is NaN
}

void check_determined(const SecondOrderFit& fit, const Point& point, const Box& box) {
  if (fit.explained < 0.5)
    refuse("a second-order mode explains ", std::round(100.0 * fit.explained),
           " % of the output, expected at least 50: use a larger step or chirp, or the right columns");
  if (point[2] >= box.hi[2])
    refuse("delay is more than ", largest_delay_cycles, " cycles of ", fit.cycle_s, " s, expected less");
  const bool at_the_edge = point[0] >= box.hi[0] - 1e-6 || point[1] >= box.hi[1] - 1e-6;
  if (at_the_edge || !is_determined(fit.natural_frequency_Hz, 1.5) || !is_determined(fit.damping_ratio, 5.0))
    throw ModeNotShown(text_of(
        "the dataset allows natural frequencies from ", range_of(fit.natural_frequency_Hz),
        " Hz and damping ratios from ", range_of(fit.damping_ratio),
        ", expected a dataset that determines both values: excite the stage more at frequencies near the "
        "resonance, record longer, or sample faster;",
        " this dataset shows only a lag between drive and output"));
  constexpr double slowest_Hz = 1.0;
  if (fit.natural_frequency_Hz.value < slowest_Hz)
    refuse("natural frequency is ", in_three_digits(fit.natural_frequency_Hz.value),
           " Hz, expected at least ", slowest_Hz, ": check the unit of the time");
  if (fit.delay_s.hi < 0.0)
    throw ModeNotShown(text_of(
        "the mode that fits best has a negative delay, ", in_three_digits(fit.delay_s.value),
        " s, which is impossible: the natural frequency is above half the sampling rate, or the input is "
        "shifted by a row; the input of a row must be ",
        "the drive that acts from the time of this row to the time of the next row"));
}

}  // namespace

SecondOrderFit fit_second_order(const Dataset& dataset) {
  const Task task(sampled(dataset, largest_delay_cycles));
  const SampledDataset& s = task.dataset;
  const Box box = searched(s);
  const std::vector<LocalMinimum> found = minima(task, box);
  const Point& point = found.front().point;
  const Projection at = task.project(point);
  const Confidence confidence = confidence_at(task, point, at);
  const Eigen::VectorXd& error = confidence.standard_error;
  const Task response(only_driven(task, point, at));
  const auto interval = [&](int coordinate) {
    return interval_of(coordinate, box, response, found, confidence);
  };

  const double rows = static_cast<double>(s.rows());
  const double slope = at.coefficients[gain], slope_error = error[3 + gain];
  const double reach = two_sided_95 * slope_error;
  SecondOrderFit fit;
  fit.natural_frequency_Hz = exponential(point[0], error[0], interval(0));
  fit.damping_ratio = exponential(point[1], error[1], interval(1));
  fit.delay_s = scaled(s.cycle_s, point[2], error[2], interval(2));
  fit.gain = scaled(s.output_scale / s.drive_scale, slope, slope_error, {slope - reach, slope + reach});
  fit.drift_per_s = at.coefficients[drift] * s.output_scale * 2.0 / s.duration_s();
  fit.residual_rms = s.output_scale * std::sqrt(at.residual.squaredNorm() / rows);
  fit.explained = 1.0 - at.residual.squaredNorm() / rows;
  fit.cycle_s = s.cycle_s;
  fit.rows = dataset.size();
  fit.left_out = static_cast<std::size_t>(s.inputs.rows()) - dataset.size();
  check_determined(fit, point, box);
  return fit;
}

}  // namespace hystcan::identification
