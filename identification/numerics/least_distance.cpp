#include "identification/numerics/least_distance.h"

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// A new inequality g . z >= h counts as dependent on the active inequalities if the part of g that is
// orthogonal to their vectors is shorter than this share of |g|.
constexpr double parallel = 1e-11;

}  // namespace

LeastDistance::LeastDistance(Index unknowns)
    : z_(VectorXd::Zero(unknowns)),
      q_(Eigen::MatrixXd::Identity(unknowns, unknowns)),
      r_(Eigen::MatrixXd::Zero(unknowns, unknowns)) {}

VectorXd LeastDistance::in_triangle(const VectorXd& of) const {
  return r_.topLeftCorner(in_force(), in_force()).triangularView<Eigen::Upper>().solve(of.head(in_force()));
}

bool LeastDistance::meet(const VectorXd& g, double h) {
  double multiplier = 0.0;
  // In each pass of this loop, an active inequality becomes inactive, or the new one is satisfied. The limit
  // is far higher than the number of passes that is ever needed; it only prevents an endless loop.
  for (Index exchanges = 10 * (z_.size() + 1); exchanges > 0; --exchanges) {
    const double lacking = h - g.dot(z_);
    if (lacking <= 0.0) return true;
    const VectorXd components = q_.transpose() * g;
    const Index free = z_.size() - in_force();
    const double independent = components.tail(free).squaredNorm();
    const bool can_move = independent > parallel * parallel * g.squaredNorm();
    const VectorXd relief = in_triangle(components);
    // The multiplier of the new inequality grows by a step. The step ends when an active inequality becomes
    // inactive (until_leaving), or when the new inequality is satisfied (until_met).
    double until_leaving = std::numeric_limits<double>::infinity();
    std::size_t leaving = 0;
    for (std::size_t i = 0; i < multipliers_.size(); ++i)
      if (const double of = relief[static_cast<Index>(i)]; of > 0.0 && multipliers_[i] < until_leaving * of) {
        until_leaving = multipliers_[i] / of;
        leaving = i;
      }
    const double until_met = can_move ? lacking / independent : std::numeric_limits<double>::infinity();
    const double step = std::min(until_leaving, until_met);
    if (!std::isfinite(step)) return false;
    if (can_move) z_ += step * (q_.rightCols(free) * components.tail(free));
    for (std::size_t i = 0; i < multipliers_.size(); ++i)
      multipliers_[i] -= step * relief[static_cast<Index>(i)];
    multiplier += step;
    if (until_met <= until_leaving) {
      enter(components);
      multipliers_.push_back(multiplier);
      return true;
    }
    drop(leaving);
  }
  return false;
}

/// Makes one more inequality active. `components`: components of its vector g along the columns of q_. The
/// first columns of q_ belong to the inequalities that are already active. Rotates the other columns so that
/// g has a component only along the first of them.
void LeastDistance::enter(const VectorXd& components) {
  const Index place = in_force();
  VectorXd of = components;
  for (Index i = of.size() - 1; i > place; --i) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(of[i - 1], of[i]);
    of.applyOnTheLeft(i - 1, i, rotation.adjoint());
    q_.applyOnTheRight(i - 1, i, rotation);
  }
  r_.col(place).head(place + 1) = of.head(place + 1);
}

void LeastDistance::drop(std::size_t which) {
  const auto place = static_cast<Index>(which);
  const Index last = in_force() - 1;
  for (Index column = place; column < last; ++column)
    r_.col(column).head(column + 2) = r_.col(column + 1).head(column + 2);
  for (Index row = place; row < last; ++row) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(r_(row, row), r_(row + 1, row));
    r_.middleCols(row, last - row).applyOnTheLeft(row, row + 1, rotation.adjoint());
    q_.applyOnTheRight(row, row + 1, rotation);
    r_(row + 1, row) = 0.0;
  }
  multipliers_.erase(multipliers_.begin() + static_cast<std::ptrdiff_t>(which));
}

}  // namespace hystcan::identification
