// A record of steps or a chirp, described by a chain of delay, lag and mode, for which a loop is designed.
//
//   y = offset + drift t + free decay + sum_i gain_i G u_i    u_i: identification/dynamics/mode_response.h
//   G: held_plant() of mode (f, zeta), amplifier's lag (1 - s) D, pure delay s D, and the stated sensor
//   y: output    D: lag and pure delay together    s: share of D that is a pure delay, 0 to 1
//
// The linear part is solved directly (variable projection), the rest by Levenberg's method. A lag lowers the
// mode's amplitude, a pure delay does not: a record that shows the mode can therefore distinguish the two.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>

#include "controller/control/delays.h"
#include "identification/dynamics/mode_response.h"
#include "identification/dynamics/second_order_fit.h"
#include "identification/numerics/nonlinear_fit.h"

namespace hystcan::app {

/// The unknowns of the chain: log(f / Hz) and log zeta of the mode; lag and pure delay together, D, in
/// cycles; the share s of D that is a pure delay.
using ChainPoint = Eigen::Vector4d;
enum ChainUnknown : Eigen::Index { log_frequency, log_damping, late_cycles, pure_share };

/// Bounds of the unknowns; an unknown whose interval is a single value is fixed.
using ChainBox = Eigen::AlignedBox<double, 4>;

class ChainRecord {
 public:
  /// `stated`: provides the sensor, and whether the amplifier interpolates. Throws std::invalid_argument like
  /// sampled().
  ChainRecord(const identification::Dataset& record, const controller::Delays& stated);

  struct Fit {
    ChainPoint at;
    double sum_of_squares = 0.0;  ///< sum of the squared residuals, for an output with variance 1
    ChainBox box;                 ///< bounds within which the point is the best
  };
  double sum_of_squares(const ChainPoint& point) const { return residual(point).squaredNorm(); }
  Fit improved(const ChainPoint& start, const ChainBox& box) const;

  /// Returns the standard errors of the free unknowns; 0 for the fixed ones.
  identification::Confidence confidence(const Fit& fit) const;

  /// Returns the chain in the form that a loop uses, without command delay.
  controller::Delays delays(const ChainPoint& at) const;
  /// Return the gain in output units per drive unit, and the RMS residual in output units.
  double gain(const ChainPoint& at) const;
  double residual_rms(const ChainPoint& at) const;
  double explained(const ChainPoint& at) const { return 1.0 - sum_of_squares(at) / rows(); }

  double cycle_s() const { return dataset_.cycle_s; }
  std::size_t cycles() const { return static_cast<std::size_t>(dataset_.inputs.rows()); }

 private:
  double rows() const { return static_cast<double>(dataset_.rows()); }
  Eigen::MatrixXd columns(const ChainPoint& point) const;
  Eigen::VectorXd residual(const ChainPoint& point) const;
  /// Returns the derivatives of the residual with respect to the free unknowns.
  Eigen::MatrixXd slope(const ChainPoint& point, const ChainBox& box) const;

  identification::SampledDataset dataset_;
  controller::Delays stated_;
};

}  // namespace hystcan::app
