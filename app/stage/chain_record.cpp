#include "app/stage/chain_record.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "controller/analysis/linear_loop.h"
#include "identification/numerics/decompositions.h"
#include "identification/numerics/nonlinear_fit.h"

namespace hystcan::app {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using identification::OrthonormalColumns;

constexpr double two_pi = 2.0 * std::numbers::pi;

// Columns of the linear equations from which offset, drift, free decay and gains are solved. The columns from
// `driven` on belong to the inputs, one column for each.
enum Column : Index { offset, drift, free_cosine, free_sine, driven };

/// Returns the indices of the unknowns that are not fixed by the bounds.
std::vector<Index> free_of(const ChainBox& box) {
  std::vector<Index> free;
  for (Index i = 0; i < ChainPoint::SizeAtCompileTime; ++i)
    if (box.min()[i] < box.max()[i]) free.push_back(i);
  return free;
}

}  // namespace

ChainRecord::ChainRecord(const identification::Dataset& record, const controller::Delays& stated)
    : dataset_(identification::sampled(record, identification::largest_delay_cycles)), stated_(stated) {
  stated_.command_delay = {};  // no delay: a row's drive is in effect from the time of the row
}

controller::Delays ChainRecord::delays(const ChainPoint& at) const {
  const double late_s = at[late_cycles] * dataset_.cycle_s;
  controller::Delays chain = stated_;
  chain.resonance_Hz = std::exp(at[log_frequency]);
  chain.damping_ratio = std::exp(at[log_damping]);
  chain.amplifier_bandwidth_Hz = 1.0 / (two_pi * (1.0 - at[pure_share]) * late_s);
  chain.sensor_delay += std::chrono::nanoseconds(std::llround(1e9 * at[pure_share] * late_s));
  return chain;
}

MatrixXd ChainRecord::columns(const ChainPoint& point) const {
  controller::Delays chain = delays(point);
  // delays() rounds the sensor's delay to nanoseconds, which would disturb numerical derivatives. Therefore
  // the exact pure delay is given to held_plant() instead.
  chain.sensor_delay = stated_.sensor_delay;
  const double pure_s = point[pure_share] * point[late_cycles] * dataset_.cycle_s;
  const auto plant = controller::held_plant(chain, dataset_.cycle_s, pure_s);
  const Index inputs = dataset_.inputs.cols(), cycles = dataset_.inputs.rows();
  MatrixXd all(cycles, inputs);
  for (Index i = 0; i < inputs; ++i) {
    auto state = controller::PlantRecursion::at_rest(dataset_.inputs(0, i));
    for (Index n = 0; n < cycles; ++n)
      all(n, i) = controller::PlantRecursion::step(
          plant, state, dataset_.inputs(std::max<Index>(n - plant.delay_cycles, 0), i));
  }
  const double decay = two_pi * chain.resonance_Hz * chain.damping_ratio * dataset_.cycle_s,
               turn = two_pi * chain.resonance_Hz * dataset_.cycle_s;
  MatrixXd rows(dataset_.rows(), driven + inputs);
  rows.col(offset).setOnes();
  rows.col(drift) = dataset_.time;
  for (Index row = 0; row < dataset_.rows(); ++row) {
    const Index cycle = dataset_.cycle_of(row);
    const auto n = static_cast<double>(cycle);
    rows(row, free_cosine) = std::exp(-decay * n) * std::cos(turn * n);
    rows(row, free_sine) = std::exp(-decay * n) * std::sin(turn * n);
    rows.row(row).tail(inputs) = all.row(dataset_.first + cycle);
  }
  return rows;
}

VectorXd ChainRecord::residual(const ChainPoint& point) const {
  auto [amplitudes, residual] = OrthonormalColumns(columns(point)).solve(dataset_.output);
  return residual;
}

MatrixXd ChainRecord::slope(const ChainPoint& point, const ChainBox& box) const {
  constexpr double h = 1e-5;
  const std::vector<Index> free = free_of(box);
  MatrixXd slope(dataset_.rows(), static_cast<Index>(free.size()));
  for (Index i = 0; i < slope.cols(); ++i) {
    const ChainPoint shift = h * ChainPoint::Unit(free[static_cast<std::size_t>(i)]);
    slope.col(i) = (residual(point + shift) - residual(point - shift)) / (2.0 * h);
  }
  return slope;
}

ChainRecord::Fit ChainRecord::improved(const ChainPoint& start, const ChainBox& box) const {
  constexpr int most_steps = 30;
  const std::vector<Index> free = free_of(box);
  const auto unknowns = static_cast<Index>(free.size());
  if (unknowns == 0) return {start, sum_of_squares(start), box};
  const auto whole = [&](const VectorXd& x) {
    ChainPoint point = start;
    for (Index i = 0; i < unknowns; ++i) point[free[static_cast<std::size_t>(i)]] = x[i];
    return point;
  };
  identification::NonlinearProblem problem;
  problem.values = [&](const VectorXd& x) -> std::optional<VectorXd> { return residual(whole(x)); };
  problem.jacobian = [&](const VectorXd& x) { return slope(whole(x), box); };
  problem.wanted = VectorXd::Zero(dataset_.rows());
  problem.weight = VectorXd::Ones(dataset_.rows());
  problem.g.resize(2 * unknowns, unknowns);
  problem.g << MatrixXd::Identity(unknowns, unknowns), -MatrixXd::Identity(unknowns, unknowns);
  problem.h.resize(2 * unknowns);
  const ChainPoint lo = box.min(), hi = box.max();
  problem.h << lo(free), -hi(free);
  const ChainPoint inside = start.cwiseMax(box.min()).cwiseMin(box.max());
  const VectorXd from = inside(free);
  const identification::Minimum found = identification::improve(problem, from, most_steps);
  return {whole(found.x), found.value, box};
}

identification::Confidence ChainRecord::confidence(const Fit& fit) const {
  const std::vector<Index> free = free_of(fit.box);
  const auto unknowns = static_cast<Index>(free.size());
  identification::Confidence of =
      identification::confidence_of(slope(fit.at, fit.box), residual(fit.at), unknowns);
  VectorXd all = VectorXd::Zero(ChainPoint::SizeAtCompileTime);
  for (Index i = 0; i < unknowns; ++i) all[free[static_cast<std::size_t>(i)]] = of.standard_error[i];
  of.standard_error = all;
  return of;
}

double ChainRecord::gain(const ChainPoint& at) const {
  const auto [amplitudes, residual] = OrthonormalColumns(columns(at)).solve(dataset_.output);
  return amplitudes[driven] * dataset_.output_scale / dataset_.drive_scale;
}

double ChainRecord::residual_rms(const ChainPoint& at) const {
  return dataset_.output_scale * std::sqrt(sum_of_squares(at) / rows());
}

}  // namespace hystcan::app
