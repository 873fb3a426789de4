// Which parameters make an invertible model.
//
// Every branch is
//
//   f(v) = f_0(v) + c - S phi(d),    increasing if  sigma S e^{-k d} < f_0'(v) / h'(v)
//
// A large k gives a large S at a reversal, so that the branch first goes the wrong way (paper, text under
// Fig. 6).  The limit of k follows from the width of the loop and the slope of the curves: for wide loops it
// is about k * width < f_0'.  docs/theory/monotonicity.md contains the proof.
//
// A scan on a grid of 200 steps over the input range checks these branches over their whole length:
//   - the branches from L_0 and from U_0;
//   - falling from any point of the branch from L_0, and rising again from any point of those;
//   - rising from any point of the branch from U_0, and falling again from any point of those.
// The last two overlap: in 20 000 random third-order models each alone refused the same models.
// The scan does not check branches that leave the virgin curve (see hysteresis.h), nor deeper loops. Every
// reversal is checked at run time.
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

/// Throws std::invalid_argument if there is an input map that does not increase. check_curves() does this
/// too.
void check_input_map(const HysteresisParameters& parameters);

struct DecreasingBranch {
  Direction direction = Direction::ascending;
  double start = 0.0;   ///< input at its start
  double target = 0.0;  ///< input at its target
  Interval wrong;       ///< inputs where it goes the wrong way
  double slope = 0.0;   ///< the lowest slope there, output units per unit of h (model/hysteresis.h)
  double input = 0.0;   ///< the place of the lowest slope
};

/// The first scanned branch that does not increase. The caller has checked the curves.
std::optional<DecreasingBranch> find_decreasing_branch(const HysteresisParameters& parameters);

/// The worst of them in each tenth of the range and each direction: about forty at most. `steps` is the size
/// of the grid; the cost grows with its square.
std::vector<DecreasingBranch> find_decreasing_branches(const HysteresisParameters& parameters,
                                                       std::size_t steps);

/// A branch does not increase. what() gives the branch, the interval and the k that would be valid.
class BranchError : public std::invalid_argument {
 public:
  BranchError(Direction of, const std::string& what) : std::invalid_argument(what), direction(of) {}
  Direction direction;
};

/// Throws BranchError if a scanned branch does not increase.
void check_branches(const HysteresisParameters& parameters);

/// The interval of this direction's k in which every scanned branch increases, for the present other k. The
/// search is limited to -300 and 1e5 per input range. The ends lie 1e-5 inside the limits, so that they stay
/// valid when written with six digits. The interval contains the present k or, if that is not valid, 0; if 0
/// is not valid either, there is none. This takes a tenth of a second at most.
std::optional<Interval> allowed_k(const HysteresisParameters& parameters, Direction direction);

}  // namespace hystcan::model
