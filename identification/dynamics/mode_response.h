// What a mode can make of the inputs u_i of a sampled dataset, linear in its amplitudes:
//
//   y = offset + drift t + a x_1 + b x_2 + sum_i gain_i x[u_i]
//
// x[u]: the mode driven by u, in equilibrium before the first fitted cycle. x_1, x_2: it decays freely from
// (x, x') = (1, 0) and from (0, 2 pi f).
#pragma once

#include <Eigen/Core>

#include "identification/dynamics/sampled_dataset.h"

namespace hystcan::identification {

/// log(f / Hz), log zeta, d / T.
using ModePoint = Eigen::Vector3d;

// The columns of the linear part; from `gain` on there is one column for each input.
enum Amplitude : Eigen::Index { offset, drift, free_position, free_velocity, gain };

class ModeResponse {
 public:
  /// For delays from -1 to `longest_delay` cycles. `dataset` must outlive this.
  ModeResponse(const SampledDataset& dataset, Eigen::Index longest_delay);

  Eigen::MatrixXd columns(const ModePoint& point) const;
  /// sum_i gain_i x[u_i]. `amplitudes` of all columns, here and below.
  Eigen::VectorXd driven(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// dy / dp for constant amplitudes, and that of the driven part alone. Central differences, with an error
  /// of order 1e-10.
  using Slope = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Slope slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;
  Slope driven_slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// x[u_0] for a delay of less than a cycle, in all cycles (with a row or not) from `longest_delay` before
  /// the first fitted one to one after the last. With m more cycles of delay it is the segment from
  /// `longest_delay` - m on.
  Eigen::VectorXd long_response(const ModePoint& point) const;

 private:
  struct Lane;
  /// `more`: amplitudes of the free decays.
  Lane lane(const ModePoint& point, const Eigen::Ref<const Eigen::VectorXd>& input, Eigen::Index first,
            const Eigen::Vector2d& more) const;
  Eigen::VectorXd combined_input(const Eigen::VectorXd& amplitudes) const;
  Slope slope_with(const ModePoint& point, const Eigen::VectorXd& amplitudes,
                   const Eigen::Vector2d& decay) const;
  Eigen::MatrixXd fitted(Eigen::MatrixXd cycles) const;

  const SampledDataset& dataset_;
  Eigen::Index longest_delay_;
  Eigen::MatrixXd
      inputs_;  // of all cycles and of some before and after them, where the drive rests; then zero
};

}  // namespace hystcan::identification
