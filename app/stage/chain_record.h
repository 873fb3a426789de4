// Fits a chain of delay, lag and mechanical mode to a record of steps or a chirp. The control loop is
// designed for this chain.
//
//   y(t) = offset + drift t + free decay + sum_i gain_i G u_i(t)
//
//   y    measured output at time t
//   u_i  inputs: the drive, and hysteresis loops that are computed from the drive
//        (identification/dynamics/sampled_dataset.h)
//   G    response of the chain, held_plant(): the mode (frequency f, damping ratio zeta), the amplifier's lag
//        (1 - s) D, the pure delay s D, and the stated sensor
//   D    lag and pure delay together
//   s    share of D that is a pure delay, 0 to 1
//
// Offset, drift, decay and gains are linear and are solved directly (variable projection). The other unknowns
// are fitted with Levenberg's method. A lag lowers the amplitude of the mode, a pure delay does not. A record
// that shows the mode can therefore distinguish lag and pure delay.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>

#include "controller/control/delays.h"
#include "identification/dynamics/mode_response.h"
#include "identification/dynamics/second_order_fit.h"
#include "identification/numerics/nonlinear_fit.h"

namespace hystcan::app {

/// The unknowns of the chain, in the order of ChainUnknown: log(f / Hz) and log(zeta) of the mode with
/// frequency f and damping ratio zeta; the sum of lag and pure delay in cycles; the share of this sum that is
/// a pure delay, 0 to 1.
using ChainPoint = Eigen::Vector4d;
enum ChainUnknown : Eigen::Index { log_frequency, log_damping, late_cycles, pure_share };

/// Bounds of the unknowns. An unknown whose lower bound equals its upper bound is fixed.
using ChainBox = Eigen::AlignedBox<double, 4>;

class ChainRecord {
 public:
  /// `record`: the measured steps or chirp. `stated`: provides the sensor's dynamics, and whether the
  /// amplifier interpolates. Throws std::invalid_argument under the same conditions as
  /// identification::sampled().
  ChainRecord(const identification::Dataset& record, const controller::Delays& stated);

  struct Fit {
    ChainPoint at;
    double sum_of_squares = 0.0;  ///< sum of the squared residuals; the output is scaled to variance 1
    ChainBox box;                 ///< bounds between which the fit was searched
  };
  double sum_of_squares(const ChainPoint& point) const { return residual(point).squaredNorm(); }
  Fit improved(const ChainPoint& start, const ChainBox& box) const;

  /// Returns the standard errors of the unknowns that were free in the fit; 0 for each fixed unknown.
  identification::Confidence confidence(const Fit& fit) const;

  /// Returns the chain as delays for the design of a loop. The command delay is 0.
  controller::Delays delays(const ChainPoint& at) const;
  /// Return the gain (output units per drive unit) and the RMS residual (output units).
  double gain(const ChainPoint& at) const;
  double residual_rms(const ChainPoint& at) const;
  double explained(const ChainPoint& at) const { return 1.0 - sum_of_squares(at) / rows(); }

  double cycle_s() const { return dataset_.cycle_s; }
  std::size_t cycles() const { return static_cast<std::size_t>(dataset_.inputs.rows()); }

 private:
  double rows() const { return static_cast<double>(dataset_.rows()); }
  Eigen::MatrixXd columns(const ChainPoint& point) const;
  Eigen::VectorXd residual(const ChainPoint& point) const;
  /// Returns the derivatives of all residuals with respect to the unknowns that are free in `box`.
  Eigen::MatrixXd slope(const ChainPoint& point, const ChainBox& box) const;

  identification::SampledDataset dataset_;
  controller::Delays stated_;
};

}  // namespace hystcan::app
