// Figures of a step: how the position y of a stage arrives at a new level of the reference r, and how noisy y
// is there. The results of a run, the command `plot` and the page show these figures. The error of one cycle
// is e = r - y.
//
//   step            the move of the reference from a resting level a to the next level b. Its time t is 0 in
//                   the cycle in which the reference stops at b (after a jump: in the cycle of the jump). The
//                   step ends when the reference leaves b.
//   band            tolerance_um of [axis.control.in_position]; without that table 1 % of |b - a|
//   settling time   t after which |e| stays inside the band; a step that ends outside has not settled
//   rise time       from the first y at 10 % of the way from a to b to the first y at 90 %
//   overshoot       max((y - b) sign(b - a), 0) / |b - a|
//
// HoldNoise is the RMS of y around its mean while the reference rests, over all levels. At each level,
// HoldNoise uses the cycles since e last entered the band. If e leaves the band, HoldNoise discards these
// cycles and begins again when e is back in the band. A level does not count if fewer than a tenth of its
// cycles are used. If levels with fewer cycles counted, the result for a noise as large as the band would be
// too small: it would contain only the short times in which e happens to stay inside the band. If the band is
// 0, every cycle is used.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace hystcan::metrics {

struct Step {
  double from_um = 0.0, to_um = 0.0, band_um = 0.0;
  double begin_s = 0.0, last_s = 0.0;  ///< times of the first and the last cycle of the step
  std::size_t cycles = 0;
  /// Time at which the position entered the band for the last time; `nullopt` if the position is outside the
  /// band.
  std::optional<double> settled_s{};
  /// Times at which the position first reached 10 % and 90 % of the way to the new level; `nullopt` if the
  /// position has not reached them.
  std::optional<double> at_tenth_s{}, at_nine_tenths_s{};
  double overshoot_um = 0.0;

  void add(double time_s, double position_um);
  std::optional<double> settling_s() const;
  std::optional<double> rise_s() const;
  /// Returns the overshoot as a fraction of the height of the step.
  double overshoot() const;
};

/// Finds the steps of the reference during a run and combines their figures. Gets one sample per cycle; its
/// memory does not grow.
class StepResponse {
 public:
  struct Result {
    std::size_t steps = 0;
    std::size_t not_settled = 0;
    double settling_s = 0.0;  ///< longest settling time of all steps that settled
    double overshoot = 0.0;   ///< largest overshoot, as a fraction of the height of its step
  };

  /// `tolerance_um`: half width of the band around the new level; 0: the band is 1 % of the step.
  explicit StepResponse(double tolerance_um) : tolerance_um_(tolerance_um) {}

  /// Adds the sample of one cycle. `time_s` may start at any value. `at_rest`: the reference does not move in
  /// this cycle.
  void add(double time_s, double reference_um, double position_um, bool at_rest);
  /// Ends the present step. Call it when the reference leaves its path, for example because the axis moves to
  /// another position in a transition. The next level then has no former level, so that the move to it does
  /// not count as a step.
  void leave();

  /// Returns the figures of all steps; the present step counts as if it ended now.
  Result result() const;
  /// Returns the latest step, which led to the present level; `nullopt` if the present level was not reached
  /// by a step.
  const std::optional<Step>& present() const { return step_; }

 private:
  static void count(const Step& step, Result& result);

  double tolerance_um_;
  std::optional<double> level_um_;  ///< last level at which the reference rested; `nullopt` if there was none
  std::optional<Step> step_;
  Result finished_;
};

/// The cycles of a record, one element per cycle. The reference rests while it is constant for ten cycles or
/// more; at the beginning of the record, it also rests if it is constant for fewer cycles. A reference of NaN
/// (in a transition) ends the step like StepResponse::leave(). A position of NaN is ignored.
struct Cycles {
  std::span<const double> time_s, reference_um, position_um;
};

/// Returns the response to the step that contains `cycle`: the reference leaves its old level, moves, or
/// reaches its new level in this cycle. Returns `nullopt` if there is no such step.
std::optional<Step> step_at(const Cycles& cycles, std::size_t cycle, double tolerance_um);
/// Returns the response to the step with the largest move of the reference, the first one of several equal
/// moves. Sets `begin` to the cycle in which the reference stops. Returns `nullopt` if there is no step.
std::optional<Step> largest_step(const Cycles& cycles, double tolerance_um, std::size_t& begin);

class HoldNoise {
 public:
  void add(double reference_um, double position_um, double band_um, bool at_rest);
  void leave();
  std::size_t samples() const { return pooled_samples_ + (counts() ? samples_ : 0); }
  double rms_um() const;

 private:
  bool counts() const { return 10 * samples_ >= at_rest_; }

  double level_um_ = 0.0;
  /// Mean position at the present level, and the sum of the squared distances from this mean.
  double mean_um_ = 0.0, sum_of_squares_ = 0.0;
  /// Sum of the squared distances of the position from its mean at each earlier level. A level does not count
  /// if fewer than a tenth of its cycles are used.
  double pooled_ = 0.0;
  std::size_t samples_ = 0, pooled_samples_ = 0;
  std::size_t at_rest_ = 0;  ///< number of cycles in which the reference has rested at the present level
};

}  // namespace hystcan::metrics
