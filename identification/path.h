// The branches that a sequence of inputs travels. Turning points, wiping out and alignment depend on the
// inputs and the thresholds alone: the path is found once, whatever the curves and k.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

/// One branch, as in model/memory.h; `below` and `parent` count in Path::branches.
struct PathBranch {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  model::Direction direction = model::Direction::ascending;
  double start = 0.0;         ///< input where it starts
  double target = 0.0;        ///< input that it goes to
  std::size_t parent = none;  ///< the branch it was reversed from; none: it starts at a threshold
  std::size_t below = none;   ///< the branch of its direction broken at the target; none: reference curve
  bool virgin = false;        ///< the ascending reference curve itself
};

/// Consecutive samples on one branch.
struct Run {
  std::size_t branch = 0;
  std::size_t begin = 0;  ///< sample
  std::size_t end = 0;    ///< one past the last
};

struct Path {
  std::vector<PathBranch> branches;  ///< in the order in which they were first travelled
  std::vector<Run> runs;             ///< cover all samples, in order
};

/// Where the memory begins: on the virgin curve, or at a threshold.
///
/// `prehistory`: inputs applied before the first sample; `inputs`: of the samples. Both folded already where
/// symmetry is even, and within the thresholds, or taken at them.
Path trace(model::Interval thresholds, model::Origin origin, std::span<const double> prehistory,
           std::span<const double> inputs);

}  // namespace hystcan::identification
