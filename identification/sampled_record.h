// A record as the fit of a mode needs it: sampled evenly, its drive moving, in units of order one.
#pragma once

#include <Eigen/Core>

#include "identification/record.h"

namespace hystcan::identification {

struct SampledRecord {
  double cycle_s = 0.0;
  double drive_scale = 1.0;   ///< input units: the largest move from the first row's drive
  double output_scale = 1.0;  ///< output units: standard deviation about a straight line
  Eigen::VectorXd time;       ///< -1 at the first row, 1 at the last
  Eigen::VectorXd drive;      ///< (input - first row's) / drive_scale
  Eigen::VectorXd output;     ///< (output - mean) / output_scale

  Eigen::Index rows() const { return time.size(); }
  double duration_s() const { return static_cast<double>(rows() - 1) * cycle_s; }
};

/// Throws std::invalid_argument where rows are too few, their times uneven beyond 1 %, or a column constant.
SampledRecord sampled(const Record& record);

/// What is left of `values` beside a straight line.
Eigen::VectorXd without_line(const Eigen::VectorXd& time, const Eigen::VectorXd& values);

}  // namespace hystcan::identification
