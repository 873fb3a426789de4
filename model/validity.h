// Checks if the parameters of a hysteresis model make a model that has an inverse: all branches must
// increase.
//
// Every branch is
//
//   f(v) = f_0(v) + c - S phi(d),    increasing if  sigma S e^{-k d} < f_0'(v) / h'(v)
//
//   f_0     reference curve of the branch's direction
//   c, S    constants of the branch; S: strength of the convergence to the surrounding loop
//   k       convergence rate, phi(d) = (1 - e^{-k d}) / k
//   d       distance from the start of the branch
//   sigma   +1 for a rising branch, -1 for a falling branch
//   h       input map, h(v) = v without a map
//
// At a reversal, a large k makes S large. The branch then first moves in the wrong direction (text under Fig.
// 6 of the paper by Bashash et al. 2009). The largest valid k depends on the width of the loop and the slope
// of the reference curves: for wide loops, approximately k * width < slope. docs/theory/monotonicity.md
// contains the proof.
//
// The check scans these branches over their whole length, on a grid of 200 steps over the input range:
//
//   - the branches from the lower convergence point L_0 and from the upper threshold point U_0;
//   - the branches that fall from a point of the branch from L_0, and the branches that rise again from
//     these;
//   - the branches that rise from a point of the branch from U_0, and the branches that fall again from
//     these.
//
// The last two groups overlap: in a trial with 20 000 random models whose curves are cubic polynomials, each
// of the two groups alone refused the same models. The scan does not include branches that leave the virgin
// curve (model/hysteresis.h), and it does not include deeper loops. The model therefore also checks every
// reversal at run time.
#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/hysteresis_parameters.h"

namespace hystcan::model {

/// Checks the reference curves and maps. Throws std::invalid_argument with the defect, its place and the
/// expected value. Defects are:
///
///   - The curves have different intervals or knots.
///   - A curve decreases, or is flat over a twentieth of the range.
///   - The curves cross, or do not meet at the upper threshold. The tolerance is 1e-9 of the output span,
///     plus rounding.
///   - The descending curve does not begin below the upper threshold point.
///   - A convergence rate k is not finite, or below -300 / input range.
///   - The input map does not increase.
///   - The output map does not have the range of the curves.
///   - The symmetry is even, but the interval starts below 0 or there is an output map.
void check_curves(const HysteresisParameters& parameters);

/// Throws std::invalid_argument if the model has an input map that does not increase. check_curves() includes
/// this check.
void check_input_map(const HysteresisParameters& parameters);

struct DecreasingBranch {
  Direction direction = Direction::ascending;
  double start = 0.0;   ///< input at the start of the branch
  double target = 0.0;  ///< input at the target of the branch
  Interval wrong;       ///< inputs between which the branch decreases
  /// Lowest slope of the branch, negative, in output units per unit of the model's input map; without an
  /// input map, in output units per input unit.
  double slope = 0.0;
  double input = 0.0;  ///< input at which the slope is lowest
};

/// Returns the first branch in the scan that does not increase; `nullopt` if all increase. check_curves()
/// must have accepted the parameters.
std::optional<DecreasingBranch> find_decreasing_branch(const HysteresisParameters& parameters);

/// Returns branches that do not increase. For each direction and each tenth of the input range, the result
/// contains the steepest decreasing branches that start in this tenth. The result has about forty elements at
/// most. `steps` is the number of grid steps; the time grows with its square.
std::vector<DecreasingBranch> find_decreasing_branches(const HysteresisParameters& parameters,
                                                       std::size_t steps);

/// Thrown if a branch of the model does not increase. what() contains the branch, the interval in which it
/// decreases, and the valid values of k.
class BranchError : public std::invalid_argument {
 public:
  BranchError(Direction of, const std::string& what) : std::invalid_argument(what), direction(of) {}
  Direction direction;
};

/// Scans the branches as described at the top of this file. Throws BranchError if a branch does not increase.
void check_branches(const HysteresisParameters& parameters);

/// Returns the interval of the convergence rate k of this direction in which every scanned branch increases.
/// The k of the other direction keeps its value. The interval contains the present k; if the present k is not
/// valid, it contains 0. Returns `nullopt` if 0 is not valid either.
///
/// The search is limited to -300 and 1e5 per input range. Each end of the interval is moved inwards from the
/// limit of valid k by a hundred-thousandth of its value, so that it stays valid when written with six
/// digits. Takes a tenth of a second at most.
std::optional<Interval> allowed_k(const HysteresisParameters& parameters, Direction direction);

}  // namespace hystcan::model
