#include "identification/dynamics/sampled_dataset.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "identification/characterisation.h"

namespace hystcan::identification {
namespace {

constexpr std::size_t fewest_rows = 30;
constexpr Eigen::Index fewest_fitted = 20;

/// Returns the first row at which the drive has visited both ends of its range since the row `from`. Returns
/// the number of rows if the drive does not visit both ends.
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

/// Returns the drive, followed by one column for the loop of each play operator (w_i in sampled_dataset.h).
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

// Returns true if the drive has only two levels. The response to such a drive has no loop.
bool is_of_two_levels(const Eigen::VectorXd& drive) {
  const double lo = drive.minCoeff(), hi = drive.maxCoeff(), near = 0.02 * (hi - lo);
  return ((drive.array() <= lo + near) || (drive.array() >= hi - near)).all();
}

/// Sets `cycles`, `output` and `time` of `s`. They contain only the fitted rows: those from cycle s.first on.
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

}  // namespace

Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values) {
  // Subtracts the mean, then the best line through zero. Both steps are independent, because the mean of
  // `time` is zero.
  const Eigen::VectorXd about_mean = values.array() - values.mean();
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

}  // namespace hystcan::identification
