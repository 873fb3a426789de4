// The conditions under which parameters make an invertible model.
//
// Every branch is
//
//   f(v) = f_0(v) + c - S phi(d),    increasing if  sigma S e^{-k d} < f_0'(v) / h'(v)
//
// A large k gives a large S at a reversal, so that the branch first moves in the wrong direction (paper, text
// under Fig. 6).  The limit of k follows from the width of the loop and the slope of the curves: for wide
// loops, k * width < f_0' approximately.  docs/theory/monotonicity.md contains the proof.
//
// A scan on a grid of 200 steps over the input range checks these branches over their whole length:
//   - the branches from L_0 and from U_0;
//   - branches that fall from a point of the branch from L_0, and branches that rise again from these;
//   - branches that rise from a point of the branch from U_0, and branches that fall again from these.
// The last two overlap: in 20 000 random third-order models each alone refused the same models. The scan
// covers neither branches that leave the virgin curve (see hysteresis.h) nor deeper loops. The model checks
// every reversal at run time.
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// Throws std::invalid_argument with the defect, its place and the expected value: intervals that differ; a k
/// that is not finite or below -300 per input range; an input map that does not increase; a curve that
/// decreases; curves that cross or do not meet at the upper threshold (to 1e-9 of the output span, rounded).
void check_curves(const HysteresisParameters& parameters);

/// Throws std::invalid_argument if there is an input map that does not increase. check_curves() includes this
/// check.
void check_input_map(const HysteresisParameters& parameters);

struct DecreasingBranch {
  Direction direction = Direction::ascending;
  double start = 0.0;   ///< input at its start
  double target = 0.0;  ///< input at its target
  Interval wrong;       ///< inputs where the branch decreases
  /// Lowest slope in `wrong`, output units per unit of h (model/hysteresis.h).
  double slope = 0.0;
  double input = 0.0;  ///< input with the lowest slope
};

/// Returns the first scanned branch that does not increase. The caller must have checked the curves.
std::optional<DecreasingBranch> find_decreasing_branch(const HysteresisParameters& parameters);

/// Returns the scanned branches that do not increase: only the worst in each tenth of the range and each
/// direction, about forty at most. `steps` is the size of the grid; the cost grows with its square.
std::vector<DecreasingBranch> find_decreasing_branches(const HysteresisParameters& parameters,
                                                       std::size_t steps);

/// Thrown if a branch does not increase. what() contains the branch, the interval and the valid k.
class BranchError : public std::invalid_argument {
 public:
  BranchError(Direction of, const std::string& what) : std::invalid_argument(what), direction(of) {}
  Direction direction;
};

/// Throws BranchError if a scanned branch does not increase.
void check_branches(const HysteresisParameters& parameters);

/// Returns the interval of k for this direction in which every scanned branch increases, with the present k
/// of the other direction. The search is limited to -300 and 1e5 per input range. The ends are 1e-5 inside
/// the limits, so that they stay valid when written with six digits. The interval contains the present k or,
/// if that k is not valid, 0. Returns `nullopt` if 0 is not valid either. Takes a tenth of a second at most.
std::optional<Interval> allowed_k(const HysteresisParameters& parameters, Direction direction);

}  // namespace hystcan::model
