// The part of a dataset that the fit uses: all turning points, and as many samples as the search can afford.
//
// The memory of an actuator depends on the turning points; between them, a few samples are as good as many. A
// delay tau shifts the input to v(t - tau), which is interpolated linearly; turning points are kept exactly.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "identification/dataset.h"
#include "model/output_creep.h"

namespace hystcan::identification {

/// A view of one dataset (folded if symmetry is even). Its samples are divided into folds for hold-out.
class Excerpt {
 public:
  /// `fold`: fold of each sample; if empty, all are in fold 0. At most `samples` samples are kept, evenly
  /// spaced. Dataset and folds must outlive the excerpt.
  Excerpt(const Dataset& dataset, std::span<const int> fold, std::size_t samples, double least_swing);

  double first_input() const { return dataset_->input.front(); }
  /// Returns the excerpt with a delayed input. Its outputs are those of the hysteresis alone: the creep,
  /// settled at the beginning, is removed. The creep does not advance during left-out samples. Inserted
  /// turning points are left out too.
  Dataset delayed_by(double delay_s, const model::OutputCreep& creep = {}) const;

 private:
  std::vector<double> outputs_without(const model::OutputCreep& creep) const;
  std::vector<double> kept_without(const model::OutputCreep& creep) const;

  const Dataset* dataset_;  // all samples: the input is interpolated between them
  std::span<const int> fold_;
  std::size_t stride_;
  std::vector<std::size_t> turning_points_;
  mutable Eigen::MatrixXd without_creep_;  // outputs of the kept samples for some weights of the creep
};

}  // namespace hystcan::identification
