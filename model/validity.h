// Which parameters make an invertible model.
//
// Every branch is f(v) = f_0(v) + c - S phi(d) and increasing where sigma S e^{-k d} < f_0'(v): a large k
// makes a reversal so steep in S that the branch first goes the wrong way (paper, text under Fig. 6).  How
// large k may be follows from the width of the loop against the slope of the curves: about k * width < f_0'
// for wide loops.
//
// Scanned, on a grid of 200 steps over the input range, each branch over its whole length:
//   the branches from L_0 and from U_0;
//   falling from any point of the branch from L_0, and rising again from any point of those;
//   rising from any point of the branch from U_0, and falling again from any point of those.
// The two scans overlap: in 20 000 random third-order models either alone refused the same ones.
// Not scanned: branches off the virgin curve (see hysteresis.h), deeper loops. Every reversal is checked at
// run time.
#pragma once

#include "model/hysteresis.h"

namespace hystcan::model {

/// Throws std::invalid_argument naming what is wrong, where, and what was expected: intervals that differ or
/// a k that is not finite or below -300 per input range; a curve that decreases; curves that cross or do not
/// meet at the upper threshold (to 1e-9 of the output span); a branch that decreases.
void check_validity(const HysteresisParameters& parameters);

}  // namespace hystcan::model
