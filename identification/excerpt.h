// A dataset as the fit sees it: turning points all, samples as many as the search can afford.
//
// What an actuator remembers hangs on the turning points; between them a few samples say as much as many. A
// delay shifts the input: v(t - tau), interpolated linearly, the turning points kept as they are.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identification/dataset.h"
#include "identification/regression.h"
#include "model/memory.h"

namespace hystcan::identification {

struct TurningPoint {
  double time_s = 0.0;
  double input = 0.0;
};

/// The input's reversals that swing by more than `least_swing`.
std::vector<TurningPoint> turning_points(const Dataset& dataset, double least_swing);

/// One dataset, folded where symmetry is even, its samples dealt into folds for hold-out.
class Excerpt {
 public:
  /// `fold`: of each sample, or none: all in fold 0. `samples`: at most so many are kept, evenly.
  Excerpt(const Dataset& dataset, std::vector<int> fold, std::size_t samples, double least_swing);

  struct Sequence {
    std::vector<double> input;
    std::vector<double> output;
    std::vector<int> fold;  ///< Regression::left_out at a turning point put in between
  };
  Sequence delayed_by(double delay_s) const;

 private:
  std::vector<double> time_s_, input_, output_;  // all samples: the input is interpolated between them
  std::vector<int> fold_;
  std::size_t stride_;
  std::vector<TurningPoint> turning_points_;
};

/// |v| in the place of v.
Dataset folded(const Dataset& dataset);

}  // namespace hystcan::identification
