#include "identification/dynamics/sampled_dataset.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text.h"
#include "identification/characterisation.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t fewest_rows = 30;
constexpr Eigen::Index fewest_fitted = 20;

/// The first row, from row `from` on, at which `drive` has visited both ends of its range; the number of
/// rows if it never does.
Eigen::Index row_after_both_ends(const Eigen::VectorXd& drive, Eigen::Index from) {
  const double lo = drive.minCoeff(), hi = drive.maxCoeff(), near = 0.02 * (hi - lo);
  bool was_low = false, was_high = false;
  for (Eigen::Index n = from; n < drive.size(); ++n) {
    was_low = was_low || drive[n] <= lo + near;
    was_high = was_high || drive[n] >= hi - near;
    if (was_low && was_high) return n;
  }
  return drive.size();
}

/// The drive, then the columns w_i.
Eigen::MatrixXd with_loops(const Eigen::VectorXd& drive) {
  const double middle = 0.5 * (drive.minCoeff() + drive.maxCoeff());
  const double half_range = drive.maxCoeff() - middle;
  Eigen::MatrixXd inputs = drive;
  for (const double part : {0.25, 0.5, 0.75}) {
    const double threshold = part * half_range;
    Eigen::VectorXd loop(drive.size());
    double play = drive[0];
    for (Eigen::Index n = 0; n < drive.size(); ++n) {
      play = std::clamp(play, drive[n] - threshold, drive[n] + threshold);
      loop[n] = (play - middle) - (1.0 - part) * (drive[n] - middle);
    }
    inputs.conservativeResize(Eigen::NoChange, inputs.cols() + 1);
    inputs.rightCols<1>() = loop;
  }
  return inputs;
}

// A drive with two levels has no loop. Its earlier rows do not matter.
bool is_of_two_levels(const Eigen::VectorXd& drive) {
  const double lo = drive.minCoeff(), hi = drive.maxCoeff(), near = 0.02 * (hi - lo);
  return ((drive.array() <= lo + near) || (drive.array() >= hi - near)).all();
}

/// The rows from s.first on.
void fit_rows_of(const Dataset& dataset, const Grid& grid, SampledDataset& s) {
  const auto begin = std::ranges::lower_bound(grid.cycles, s.first);
  for (auto cycle = begin; cycle != grid.cycles.end(); ++cycle) s.cycles.push_back(*cycle - s.first);
  const auto rows = static_cast<Eigen::Index>(s.cycles.size());
  s.output =
      Eigen::Map<const Eigen::VectorXd>(dataset.output.data(), static_cast<Eigen::Index>(dataset.size()))
          .tail(rows);
  s.output.array() -= s.output.mean();
  s.time.resize(rows);
  for (Eigen::Index n = 0; n < rows; ++n)
    s.time[n] = 2.0 * static_cast<double>(s.cycles[static_cast<std::size_t>(n)]) /
                static_cast<double>(s.length() - 1);
  s.time.array() -= s.time.mean();
}

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index cycles_before =
    2;  // beyond the longest delay: the difference in a slope, and the input before
constexpr Index cycles_after = 3;  // a delay of -1 cycle and a little less, and the end of a long response

}  // namespace

Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values) {
  const Eigen::VectorXd about_mean = values.array() - values.mean();  // the mean of the times is zero
  return about_mean - time * (time.dot(about_mean) / time.squaredNorm());
}

SampledDataset sampled(const Dataset& dataset, Eigen::Index longest_delay_cycles) {
  if (dataset.size() < fewest_rows)
    refuse("dataset of ", dataset.size(), " rows, expected at least ", fewest_rows);
  check_limits(dataset);
  SampledDataset s;
  const Grid grid = grid_of(dataset.time_s);
  s.cycle_s = grid.cycle_s;
  Eigen::VectorXd drive = held_on(grid, dataset.input).array() - dataset.input.front();
  s.drive_scale = drive.cwiseAbs().maxCoeff();
  if (s.drive_scale == 0.0) refuse("input is constant, expected a step or a chirp");
  drive /= s.drive_scale;
  s.inputs = drive;
  const Eigen::Index wiped = row_after_both_ends(drive, 0) + longest_delay_cycles + 1;
  if (row_after_both_ends(drive, wiped) + fewest_fitted < drive.size()) {
    s.first = wiped;
    if (!is_of_two_levels(drive.tail(drive.size() - wiped))) s.inputs = with_loops(drive);
  }
  fit_rows_of(dataset, grid, s);
  s.output_scale = std::sqrt(without_line(s.time, s.output).squaredNorm() / static_cast<double>(s.rows()));
  if (!(s.output_scale > 1e-12 * s.output.cwiseAbs().maxCoeff()))
    refuse("output is a straight line, expected a response to the input");
  s.output /= s.output_scale;
  return s;
}

/// A mode on its way.
struct ModeResponse::Lane {
  model::HeldMode mode;
  const double* drive;  ///< u[n - m], from the first cycle on; u[n - m - 1] stands before it
  Eigen::Vector2d state;

  /// The positions of two lanes: the same operations on two numbers at a time.
  static void run(const Lane& a, const Lane& b, Eigen::Ref<VectorXd> of_a, Eigen::Ref<VectorXd> of_b) {
    using Two = Eigen::Array2d;
    const Eigen::Matrix2d &from_a = a.mode.transition(), &from_b = b.mode.transition();
    const Two pp(from_a(0, 0), from_b(0, 0)), pv(from_a(0, 1), from_b(0, 1)), vp(from_a(1, 0), from_b(1, 0)),
        vv(from_a(1, 1), from_b(1, 1));
    const Two p_old(a.mode.from_old()[0], b.mode.from_old()[0]),
        v_old(a.mode.from_old()[1], b.mode.from_old()[1]), p_new(a.mode.from_new()[0], b.mode.from_new()[0]),
        v_new(a.mode.from_new()[1], b.mode.from_new()[1]);
    Two position(a.state[0], b.state[0]), velocity(a.state[1], b.state[1]), before(a.drive[-1], b.drive[-1]);
    double *to_a = of_a.data(), *to_b = of_b.data();
    for (Index n = 0; n < of_a.size(); ++n) {
      to_a[n] = position[0];
      to_b[n] = position[1];
      const Two now(a.drive[n], b.drive[n]);
      const Two next = pp * position + pv * velocity + p_old * before + p_new * now;
      velocity = vp * position + vv * velocity + v_old * before + v_new * now;
      position = next;
      before = now;
    }
  }
};

ModeResponse::ModeResponse(const SampledDataset& dataset, Index longest_delay)
    : dataset_(dataset),
      longest_delay_(longest_delay),
      inputs_(longest_delay + cycles_before + dataset.inputs.rows() + cycles_after,
              dataset.inputs.cols() + 1) {
  const Index before = longest_delay + cycles_before, inputs = dataset.inputs.cols();
  inputs_.topLeftCorner(before, inputs).rowwise() = dataset.inputs.row(0);
  inputs_.block(before, 0, dataset.inputs.rows(), inputs) = dataset.inputs;
  inputs_.bottomLeftCorner(cycles_after, inputs).rowwise() = dataset.inputs.row(dataset.inputs.rows() - 1);
  inputs_.rightCols<1>().setZero();
}

/// Begins at cycle `first`, counted from the first fitted one, in equilibrium with the input before, and
/// `more`.
ModeResponse::Lane ModeResponse::lane(const ModePoint& point, const Eigen::Ref<const VectorXd>& input,
                                      Index first, const Eigen::Vector2d& more) const {
  const double f = std::exp(point[0]);
  const model::HeldMode mode({f, std::exp(point[1])}, point[2] * dataset_.cycle_s, dataset_.cycle_s);
  const double* drive =
      input.data() + longest_delay_ + cycles_before + dataset_.first + first - mode.whole_cycles();
  return {mode, drive, {drive[-1] + more[0], 2.0 * std::numbers::pi * f * more[1]}};
}

VectorXd ModeResponse::combined_input(const VectorXd& amplitudes) const {
  return inputs_.leftCols(inputs_.cols() - 1) * amplitudes.tail(inputs_.cols() - 1);
}

Eigen::MatrixXd ModeResponse::fitted(Eigen::MatrixXd cycles) const {
  if (dataset_.rows() == cycles.rows()) return cycles;
  return cycles(dataset_.cycles, Eigen::all);
}

Eigen::MatrixXd ModeResponse::columns(const ModePoint& point) const {
  const Index inputs = inputs_.cols() - 1;
  Eigen::MatrixXd cycles(dataset_.length(), gain + inputs);
  const Lane position = lane(point, inputs_.col(inputs), 0, {1.0, 0.0}),
             velocity = lane(point, inputs_.col(inputs), 0, {0.0, 1.0});
  Lane::run(position, velocity, cycles.col(free_position), cycles.col(free_velocity));
  for (Index i = 0; i < inputs; i += 2) {
    const bool has_pair = i + 1 < inputs;
    const Lane one = lane(point, inputs_.col(i), 0, Eigen::Vector2d::Zero());
    Lane::run(one, has_pair ? lane(point, inputs_.col(i + 1), 0, Eigen::Vector2d::Zero()) : one,
              cycles.col(gain + i), cycles.col(has_pair ? gain + i + 1 : offset));
  }
  Eigen::MatrixXd rows = fitted(std::move(cycles));
  rows.col(offset).setOnes();
  rows.col(drift) = dataset_.time;
  return rows;
}

VectorXd ModeResponse::driven(const ModePoint& point, const VectorXd& amplitudes) const {
  const VectorXd input = combined_input(amplitudes);
  Eigen::MatrixXd cycles(dataset_.length(), 2);
  const Lane one = lane(point, input, 0, Eigen::Vector2d::Zero());
  Lane::run(one, one, cycles.col(0), cycles.col(1));
  return fitted(std::move(cycles)).col(0);
}

ModeResponse::Slope ModeResponse::slope(const ModePoint& point, const VectorXd& amplitudes) const {
  return slope_with(point, amplitudes, {amplitudes[free_position], amplitudes[free_velocity]});
}

ModeResponse::Slope ModeResponse::driven_slope(const ModePoint& point, const VectorXd& amplitudes) const {
  return slope_with(point, amplitudes, Eigen::Vector2d::Zero());
}

ModeResponse::Slope ModeResponse::slope_with(const ModePoint& point, const VectorXd& amplitudes,
                                             const Eigen::Vector2d& decay) const {
  constexpr double h = 1e-5;
  const VectorXd input = combined_input(amplitudes);
  Eigen::MatrixXd cycles(dataset_.length(), 3);
  VectorXd less(dataset_.length());
  for (int i = 0; i < 3; ++i) {
    const ModePoint shift = h * ModePoint::Unit(i);
    Lane::run(lane(point + shift, input, 0, decay), lane(point - shift, input, 0, decay), cycles.col(i),
              less);
    cycles.col(i) = (cycles.col(i) - less) / (2.0 * h);
  }
  return fitted(std::move(cycles));
}

VectorXd ModeResponse::long_response(const ModePoint& point) const {
  Eigen::MatrixXd cycles(longest_delay_ + dataset_.length() + 1, 2);
  const Lane one = lane(point, inputs_.col(0), -longest_delay_, Eigen::Vector2d::Zero());
  Lane::run(one, one, cycles.col(0), cycles.col(1));
  return cycles.col(0);
}

}  // namespace hystcan::identification
