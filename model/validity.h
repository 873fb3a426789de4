// Which parameters make an invertible model.
//
// Every branch is f(v) = f_0(v) + c - S phi(d) and increasing where sigma S e^{-k d} < f_0'(v): a large k
// makes a reversal so steep in S that the branch first goes the wrong way (paper, text under Fig. 6).  How
// large k may be follows from the width of the loop against the slope of the curves: about k * width < f_0'
// for wide loops.  docs/theory.md has the proof.
//
// Scanned, on a grid of 200 steps over the input range, each branch over its whole length:
//   the branches from L_0 and from U_0;
//   falling from any point of the branch from L_0, and rising again from any point of those;
//   rising from any point of the branch from U_0, and falling again from any point of those.
// The two scans overlap: in 20 000 random third-order models either alone refused the same ones.
// Not scanned: branches off the virgin curve (see hysteresis.h), deeper loops. Every reversal is checked at
// run time.
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// Throws std::invalid_argument naming what is wrong, where, and what was expected: intervals that differ, a
/// k that is not finite or below -300 per input range; a curve that decreases; curves that cross or do not
/// meet at the upper threshold (to 1e-9 of the output span).
void check_curves(const HysteresisParameters& parameters);

struct DecreasingBranch {
  Direction direction = Direction::ascending;
  double start = 0.0;   ///< input where it starts
  double target = 0.0;  ///< input of its target
  Interval wrong;       ///< inputs where it goes the wrong way
  double slope = 0.0;   ///< the lowest found there, output units per input unit
  double input = 0.0;   ///< where that is
};

/// The first scanned branch that is not increasing. The curves have been checked.
std::optional<DecreasingBranch> find_decreasing_branch(const HysteresisParameters& parameters);

/// The worst of them in every tenth of the range and direction: some forty at most. `steps`: of the grid;
/// the cost goes with its square.
std::vector<DecreasingBranch> find_decreasing_branches(const HysteresisParameters& parameters,
                                                       std::size_t steps);

/// A branch that is not increasing: what() names it, the interval, and what k would do.
class BranchError : public std::invalid_argument {
 public:
  BranchError(Direction of, const std::string& what) : std::invalid_argument(what), direction(of) {}
  Direction direction;
};

/// Throws BranchError where one is found.
void check_branches(const HysteresisParameters& parameters);

/// The k of this direction that keep every scanned branch increasing, the other k as it is: within -300 and
/// 1e5 per input range. Its ends are 1e-5 within the limits, so that they will do when written with six
/// digits. Around the k in use or, where that won't do, around 0; none where that won't do either. A tenth of
/// a second at most.
std::optional<Interval> allowed_k(const HysteresisParameters& parameters, Direction direction);

}  // namespace hystcan::model
