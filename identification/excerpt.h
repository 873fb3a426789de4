// Selects the part of a dataset that a fit uses: all turning points, and as many samples as the search has
// time for.
//
// The memory of an actuator depends only on the turning points; between them, a few samples are as good as
// many. With a delay tau, a sample at the time t gets the input of the dataset at t - tau, which is
// interpolated linearly. The turning points keep their exact inputs.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "identification/dataset.h"
#include "model/output_creep.h"

namespace hystcan::identification {

/// A view of one dataset. Its samples may be divided into folds (struct Folds in dataset.h). If the model has
/// even symmetry, the dataset must contain the magnitudes of the inputs.
class Excerpt {
 public:
  /// `fold`: the fold of each sample; if it is empty, all samples are in fold 0. At most `samples` samples
  /// are kept, evenly spaced. `dataset` and `fold` must exist as long as the excerpt.
  Excerpt(const Dataset& dataset, std::span<const int> fold, std::size_t samples, double least_swing);

  double first_input() const { return dataset_->input.front(); }
  /// Returns the kept samples with a delayed input and without creep. The outputs are then those of the
  /// hysteresis alone. The creep is settled at the first sample, and it does not advance at samples that are
  /// left out. The result also contains all turning points, because the memory depends on them; they are
  /// marked as left out.
  Dataset delayed_by(double delay_s, const model::OutputCreep& creep = {}) const;

 private:
  std::vector<double> outputs_without(const model::OutputCreep& creep) const;
  std::vector<double> kept_without(const model::OutputCreep& creep) const;

  // The whole dataset, because the delayed input is interpolated between all its samples.
  const Dataset* dataset_;
  std::span<const int> fold_;
  std::size_t stride_;
  std::vector<std::size_t> turning_points_;
  // Outputs of the kept samples after the creep was removed. Column j belongs to the j-th of twelve values of
  // the creep weight w (model/output_creep.h). kept_without() interpolates the outputs for any other w. The
  // matrix is computed when it is first needed.
  mutable Eigen::MatrixXd without_creep_;
};

}  // namespace hystcan::identification
