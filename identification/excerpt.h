// The part of a dataset that the fit uses: all turning points, and as many samples as the search can afford.
//
// The memory of an actuator depends on the turning points; between them a few samples are as good as many. A
// delay tau shifts the input to v(t - tau), which is interpolated linearly; turning points are kept exactly.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identification/dataset.h"
#include "identification/regression.h"
#include "model/memory.h"
#include "model/output_creep.h"

namespace hystcan::identification {

struct TurningPoint {
  double time_s = 0.0;
  double input = 0.0;
};

/// The reversals of the input after a swing of more than `least_swing`.
std::vector<TurningPoint> turning_points(const Dataset& dataset, double least_swing);

/// The smallest swing that counts as a turning point in a search, where the inputs of all datasets have this span: smaller
/// ones are noise, and the kept samples are enough for them.
double least_swing(const Dataset& dataset, double span);

/// The samples from one turning point to the next, both included.
struct HalfCycle {
  std::size_t begin = 0, end = 0;  ///< samples
  double from = 0.0, to = 0.0;     ///< input
};

/// All samples, divided at the turning points.
std::vector<HalfCycle> half_cycles(const Dataset& dataset, double least_swing);

/// One dataset, folded if symmetry is even. Its samples are divided into folds for hold-out.
class Excerpt {
 public:
  /// `fold`: the fold of each sample; if empty, all are in fold 0. At most `samples` are kept, evenly.
  Excerpt(const Dataset& dataset, std::vector<int> fold, std::size_t samples, double least_swing);

  struct Sequence {
    std::vector<double> time_s;  ///< of the output
    std::vector<double> input;
    std::vector<double> output;
    std::vector<double> weight;                   ///< of the output's error
    std::vector<std::vector<double>> regressors;  ///< as the dataset's
    std::vector<int> fold;                        ///< Regression::left_out at an inserted turning point
  };
  /// The outputs are those of the hysteresis alone: without the creep, which begins settled. The time of samples that are
  /// left out does not pass for it.
  Sequence delayed_by(double delay_s, const model::OutputCreep& creep = {}) const;

 private:
  std::vector<double> outputs_without(const model::OutputCreep& creep) const;

  std::vector<double> time_s_, input_, output_,
      weight_;  // all samples: the input is interpolated between them
  std::vector<std::vector<double>> regressors_;
  std::vector<int> fold_;
  std::size_t stride_;
  std::vector<TurningPoint> turning_points_;
};

/// The dataset with |v| in the place of v.
Dataset folded(const Dataset& dataset);

}  // namespace hystcan::identification
