// Finds the branches along which a sequence of inputs moves. Turning points, wiping out and curve alignment
// depend only on the inputs and the thresholds. Therefore a fit needs only one path for all reference curves
// and all convergence rates that it tries.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "model/memory.h"
#include "model/reference_curve.h"

namespace hystcan::identification {

/// One branch of a path, as defined in model/memory.h. `below` and `parent` are indices of Path::branches.
struct PathBranch {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  model::Direction direction = model::Direction::ascending;
  double start = 0.0;  ///< input at the start of the branch
  /// Input at the target of the branch. When the input passes it, the inner loop closes. The target is the
  /// turning point where the parent started, or the opposite threshold.
  double target = 0.0;
  /// Branch on which the input reversed; `none` if the branch starts at a threshold.
  std::size_t parent = none;
  /// Branch of the same direction on which the path continues when the input passes `target` (curve
  /// alignment); `none` if the path then continues on the reference curve.
  std::size_t below = none;
  bool virgin = false;  ///< true for the ascending reference curve itself
};

/// Consecutive samples on the same branch.
struct Run {
  std::size_t branch = 0;
  std::size_t begin = 0;  ///< index of the first sample
  std::size_t end = 0;    ///< index after the last sample
};

struct Path {
  std::vector<PathBranch> branches;  ///< in the order in which the path reaches them
  std::vector<Run> runs;             ///< all samples in order, divided at each change of the branch
};

/// Returns the path of a sequence of inputs. It begins at `origin`: on the virgin curve or at a threshold.
///
/// `prehistory` contains the inputs before the first sample, and `inputs` the input of each sample. If
/// symmetry is even, the caller must first replace these inputs by their magnitudes. An input beyond a
/// threshold is replaced by the threshold.
Path trace(model::Interval thresholds, model::Origin origin, std::span<const double> prehistory,
           std::span<const double> inputs);

}  // namespace hystcan::identification
