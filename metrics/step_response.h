// How the position y of a stage arrives at the levels of a reference r, and the noise of y there. The results
// of a run, `plot` and the page show these figures for a step. e = r - y is the error of one cycle.
//
//   step            the move of the reference from one resting level a to the next one b. Its time t is 0 in
//                   the cycle in which the reference stops at b (after a jump: in the cycle of the jump); the
//                   step ends when the reference leaves b
//   band            tolerance_um of [axis.control.in_position]; without that table 1 % of |b - a|
//   settling time   t after which |e| stays inside the band; a step that ends outside has not settled
//   rise time       from the first y at 10 % of the way from a to b to the first y at 90 %
//   overshoot       max((y - b) sign(b - a), 0) / |b - a|
//
// HoldNoise is the RMS of y around its mean at each level, over all levels. A level counts from the cycle in
// which e is inside the band, and restarts if e leaves the band. A level of which less than a tenth remains
// does not count: otherwise a noise as large as the band would be represented by its quietest part. If the
// band is 0, everything counts.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace hystcan::metrics {

struct Step {
  double from_um = 0.0, to_um = 0.0, band_um = 0.0;
  double begin_s = 0.0, last_s = 0.0;  ///< times of the first and the last cycle
  std::size_t cycles = 0;
  std::optional<double> settled_s{};  ///< time since which y is inside the band; nullopt: outside
  /// Times at which the position reached 10 % and 90 % of the way.
  std::optional<double> at_tenth_s{}, at_nine_tenths_s{};
  double overshoot_um = 0.0;

  void add(double time_s, double position_um);
  std::optional<double> settling_s() const;
  std::optional<double> rise_s() const;
  /// Overshoot as a fraction of the step.
  double overshoot() const;
};

/// Processes one sample per cycle, in constant memory.
class StepResponse {
 public:
  struct Result {
    std::size_t steps = 0;
    std::size_t not_settled = 0;
    double settling_s = 0.0;  ///< longest settling time of the settled steps
    double overshoot = 0.0;   ///< the largest, as a fraction of its step
  };

  /// `tolerance_um`: 0 if not configured.
  explicit StepResponse(double tolerance_um) : tolerance_um_(tolerance_um) {}

  /// Adds a cycle. `time_s` may have any origin; `at_rest`: the reference does not move.
  void add(double time_s, double reference_um, double position_um, bool at_rest);
  /// Ends the step, because the reference leaves its path, as in a transition. The move to the next level is
  /// not a step.
  void leave();

  /// Includes the present step, up to now.
  Result result() const;
  /// The move to the present level; nullopt if there was none.
  const std::optional<Step>& present() const { return step_; }

 private:
  static void count(const Step& step, Result& result);

  double tolerance_um_;
  std::optional<double> level_um_;  ///< last level at which the reference rested
  std::optional<Step> step_;
  Result finished_;
};

/// The cycles of a record. The reference rests if it is constant for ten cycles, or from the first cycle on.
/// A reference of NaN ends the step like leave(), as in a transition. A position that is NaN is ignored.
struct Cycles {
  std::span<const double> time_s, reference_um, position_um;
};

/// Returns the response to the step in which the reference leaves its level in `cycle`, or is moving then;
/// nullopt if there is none.
std::optional<Step> step_at(const Cycles& cycles, std::size_t cycle, double tolerance_um);
/// Returns the response to the largest step, the first of several equal ones. Sets `begin` to the cycle in
/// which the reference stops.
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
  double mean_um_ = 0.0, sum_of_squares_ = 0.0;  ///< at the present level, around its mean
  double pooled_ = 0.0;                          ///< sum of squares at the earlier levels
  std::size_t samples_ = 0, pooled_samples_ = 0;
  std::size_t at_rest_ = 0;  ///< cycles at the present level
};

}  // namespace hystcan::metrics
