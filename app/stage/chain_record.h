// A chain of delay, lag and mode in a record of steps or a chirp: what a loop is designed for.
//
//   y = offset + drift t + free decay + sum_i gain_i G u_i    u_i: identification/dynamics/mode_response.h
//   G: held_plant() of mode (f, zeta), amplifier's lag (1 - s) D, pure delay s D, and the stated sensor
//
// The linear part is solved for directly (variable projection), the rest by Levenberg's method. A lag lowers
// the mode's amplitude, a pure delay does not: so a record that shows the mode can tell them apart.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>

#include "controller/control/delays.h"
#include "identification/dynamics/mode_response.h"
#include "identification/dynamics/second_order_fit.h"
#include "identification/numerics/nonlinear_fit.h"

namespace hystcan::app {

/// log(f / Hz), log zeta, D in cycles, s.
using ChainPoint = Eigen::Vector4d;
enum ChainUnknown : Eigen::Index { log_frequency, log_damping, late_cycles, pure_share };

/// Where the unknowns may be; one whose interval is a single value is known.
using ChainBox = Eigen::AlignedBox<double, 4>;

class ChainRecord {
 public:
  /// `stated`: the sensor, and whether the amplifier interpolates. Throws std::invalid_argument like
  /// sampled().
  ChainRecord(const identification::Dataset& record, const controller::Delays& stated);

  struct Fit {
    ChainPoint at;
    double sum_of_squares = 0.0;  ///< of the residuals, of an output with variance 1
    ChainBox box;                 ///< in which it is the best
  };
  double sum_of_squares(const ChainPoint& point) const { return residual(point).squaredNorm(); }
  Fit improved(const ChainPoint& start, const ChainBox& box) const;

  /// Standard errors of the unknowns that are not known; 0 for the others.
  identification::Confidence confidence(const Fit& fit) const;

  /// The chain as a loop has it, without command delay.
  controller::Delays delays(const ChainPoint& at) const;
  /// Output units per drive unit, and the residual in output units.
  double gain(const ChainPoint& at) const;
  double residual_rms(const ChainPoint& at) const;
  double explained(const ChainPoint& at) const { return 1.0 - sum_of_squares(at) / rows(); }

  double cycle_s() const { return dataset_.cycle_s; }
  std::size_t cycles() const { return static_cast<std::size_t>(dataset_.inputs.rows()); }

 private:
  double rows() const { return static_cast<double>(dataset_.rows()); }
  Eigen::MatrixXd columns(const ChainPoint& point) const;
  Eigen::VectorXd residual(const ChainPoint& point) const;
  /// Of the residual, in the unknowns that are not known.
  Eigen::MatrixXd slope(const ChainPoint& point, const ChainBox& box) const;

  identification::SampledDataset dataset_;
  controller::Delays stated_;
};

}  // namespace hystcan::app
