// Computes the response y of a second-order mode to the inputs u_i of a sampled dataset. The response is
// linear in its amplitudes offset, drift, a, b and gain_i:
//
//   y = offset + drift t + a x_1 + b x_2 + sum_i gain_i x[u_i]
//
//   x[u]       the mode driven by u, in equilibrium before the first fitted cycle
//   x_1, x_2   free decays of the mode, from (x, x') = (1, 0) and from (0, 2 pi f), f: natural frequency
#pragma once

#include <Eigen/Core>

#include "identification/dynamics/sampled_dataset.h"

namespace hystcan::identification {

/// A mode with a delay: log of the frequency in Hz, log of the damping ratio, and delay in cycles.
using ModePoint = Eigen::Vector3d;

// The response is a sum of columns, each multiplied by its amplitude. These are the indices of the columns:
// `gain` is the response to the first input, and the responses to the other inputs follow.
enum Amplitude : Eigen::Index { offset, drift, free_position, free_velocity, gain };

class ModeResponse {
 public:
  /// Prepares responses for delays from -1 to `longest_delay` cycles. `dataset` must exist as long as the
  /// object.
  ModeResponse(const SampledDataset& dataset, Eigen::Index longest_delay);

  Eigen::MatrixXd columns(const ModePoint& point) const;
  /// Returns the part of the response that the inputs drive, without offset, drift and free decays.
  /// In all functions of this class, `amplitudes` has one element for each column of columns().
  Eigen::VectorXd driven(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// Return the derivatives of the response by frequency, damping and delay (a ModePoint), with constant
  /// amplitudes. slope() is for the whole response without offset and drift; driven_slope() is for the part
  /// that the inputs drive. Computed by central differences, with an error of order 1e-10.
  using Slope = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Slope slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;
  Slope driven_slope(const ModePoint& point, const Eigen::VectorXd& amplitudes) const;

  /// Returns the response to the first input alone, as one value per cycle (with or without a row). The
  /// values begin `longest_delay` cycles before the first fitted cycle and end one cycle after the last one.
  /// The delay in `point` must be less than a cycle. A delay that is m cycles longer shifts the response by m
  /// cycles: its value in the first fitted cycle is the value at index `longest_delay` - m.
  Eigen::VectorXd long_response(const ModePoint& point) const;

 private:
  struct Lane;
  /// Returns a simulation of the mode that begins at cycle `first`, counted from the first fitted cycle.
  /// `more`: amplitudes of the free decays.
  Lane lane(const ModePoint& point, const Eigen::Ref<const Eigen::VectorXd>& input, Eigen::Index first,
            const Eigen::Vector2d& more) const;
  Eigen::VectorXd combined_input(const Eigen::VectorXd& amplitudes) const;
  Slope slope_with(const ModePoint& point, const Eigen::VectorXd& amplitudes,
                   const Eigen::Vector2d& decay) const;
  Eigen::MatrixXd fitted(Eigen::MatrixXd cycles) const;

  const SampledDataset& dataset_;
  Eigen::Index longest_delay_;
  // The inputs in all cycles, one column for each input. Before the first cycle and after the last cycle, the
  // drive rests: additional rows repeat the first and the last input. The last column is zero, for free
  // decays.
  Eigen::MatrixXd inputs_;
};

}  // namespace hystcan::identification
