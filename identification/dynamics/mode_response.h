// The response of a mode to the inputs u_i of a sampled dataset, linear in its amplitudes:
//
//   y = offset + drift t + a x_1 + b x_2 + sum_i gain_i x[u_i]
//
// x[u]: the mode driven by u, in equilibrium before the first fitted cycle. x_1, x_2: free decays from (x,
// x') = (1, 0) and from (0, 2 pi f).
#pragma once

#include <Eigen/Core>

#include "identification/dynamics/sampled_dataset.h"

namespace hystcan::identification {

/// log(f / Hz), log zeta, d / T.
using ModePoint = Eigen::Vector3d;

// The columns of the linear part; each input has one column, starting at `gain`.
enum Amplitude : Eigen::Index { offset, drift, free_position, free_velocity, gain };

class ModeResponse {
 public:
  /// Prepares responses for delays from -1 to `longest_delay` cycles. `dataset` must outlive the object.
  ModeResponse(const SampledDataset& dataset, Eigen::Index longest_delay);

  Eigen::MatrixXd columns(const ModePoint& point) const;
  /// Returns sum_i gain_i x[u_i]. Here and below, `amplitudes` contains the amplitudes of all columns.
  Eigen::VectorXd driven(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// Return dy / dp, the derivatives of the response by the mode point for constant amplitudes: of the whole
  /// response, and of its driven part only. By central differences, with an error of order 1e-10.
  using Slope = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Slope slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;
  Slope driven_slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// Returns x[u_0] for a delay of less than a cycle, in all cycles (with a row or not) from `longest_delay`
  /// before the first fitted cycle to one after the last. For m more cycles of delay, use the segment that
  /// starts at `longest_delay` - m.
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
  // Inputs of all cycles, of some cycles before and after them in which the drive rests, and zeros after
  // these.
  Eigen::MatrixXd inputs_;
};

}  // namespace hystcan::identification
