// The branches along which a sequence of inputs moves. Turning points, wiping out and alignment depend only
// on the inputs and the thresholds, so one path serves all curves and all k.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

/// One branch, as defined in model/memory.h. `below` and `parent` are indices of Path::branches.
struct PathBranch {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  model::Direction direction = model::Direction::ascending;
  double start = 0.0;         ///< input at its start
  double target = 0.0;        ///< input at its target
  std::size_t parent = none;  ///< branch on which the reversal was; `none`: this one starts at a threshold
  /// Branch of the same direction that ended at the target; `none`: reference curve.
  std::size_t below = none;
  bool virgin = false;  ///< the ascending reference curve itself
};

/// Consecutive samples on one branch.
struct Run {
  std::size_t branch = 0;
  std::size_t begin = 0;  ///< index of its first sample
  std::size_t end = 0;    ///< one past the last
};

struct Path {
  std::vector<PathBranch> branches;  ///< in the order of their first use
  std::vector<Run> runs;             ///< cover all samples, in order
};

/// Returns the path from `origin`: the virgin curve or a threshold.
///
/// `prehistory` contains the inputs before the first sample, `inputs` the inputs of the samples. Both must
/// already be folded if symmetry is even. Inputs beyond a threshold are replaced by the threshold.
Path trace(model::Interval thresholds, model::Origin origin, std::span<const double> prehistory,
           std::span<const double> inputs);

}  // namespace hystcan::identification
