// How a stage arrives at the levels of a reference r, and how quietly it stays there. These are the figures
// of a step wherever hystcan shows one: in the results of a run, in `plot`, on the page. e = r - y is the
// error of one cycle.
//
//   step            the move of the reference from one resting level a to the next one b. Its time t is 0
//                   in the cycle in which the reference comes to rest at b (a jump: in the cycle of its
//                   change), until it leaves b
//   band            tolerance_um of [axis.control.in_position]; without that table 1 % of |b - a|
//   settling time   t from which on |e| is inside the band and leaves it no more; a step that ends outside
//                   has not settled
//   rise time       from the first y that is 10 % of the way from a to b, to the first one that is 90 %
//   overshoot       max((y - b) sign(b - a), 0) / |b - a|
//
// HoldNoise is the RMS of y around its mean at each level, over all levels. A level counts from the cycle in
// which e is inside the band, and again from the start where e leaves it. Where less than a tenth of the
// level is left of it, it does not count: a noise as large as the band would show as its quietest moment.
// With band 0 everything counts.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace hystcan::metrics {

struct Step {
  double from_um = 0.0, to_um = 0.0, band_um = 0.0;
  double begin_s = 0.0, last_s = 0.0;  ///< times of its first and its last cycle
  std::size_t cycles = 0;
  std::optional<double> settled_s{};  ///< since then inside the band; empty: it is outside
  std::optional<double> at_tenth_s{}, at_nine_tenths_s{};  ///< when 10 % and 90 % of the way were behind it
  double overshoot_um = 0.0;

  void add(double time_s, double position_um);
  std::optional<double> settling_s() const;
  std::optional<double> rise_s() const;
  /// As a share of the step.
  double overshoot() const;
};

/// Takes one sample a cycle, in constant memory.
class StepResponse {
 public:
  struct Result {
    std::size_t steps = 0;
    std::size_t not_settled = 0;
    double settling_s = 0.0;  ///< the longest of those that have settled
    double overshoot = 0.0;   ///< the largest
  };

  /// `tolerance_um`: 0 where it is not configured.
  explicit StepResponse(double tolerance_um) : tolerance_um_(tolerance_um) {}

  /// `time_s` is of any origin; `at_rest`: the reference does not move.
  void add(double time_s, double reference_um, double position_um, bool at_rest);
  /// The reference leaves this part of its path: the step ends, and the next level is the first one again.
  void leave();

  /// The present step, as far as it has come, counts.
  Result result() const;
  /// The move to the present level, if there was one.
  const std::optional<Step>& present() const { return step_; }

 private:
  static void count(const Step& step, Result& result);

  double tolerance_um_;
  std::optional<double> level_um_;  ///< where the reference rested last
  std::optional<Step> step_;
  Result finished_;
};

/// Cycles of a record. The reference rests where it stays the same for ten cycles, or from the first one on.
/// Where it is NaN it leaves this part of its path, as in a transition.
/// A position that is NaN does not count.
struct Cycles {
  std::span<const double> time_s, reference_um, position_um;
};

/// The response to the step in which the reference leaves its level in `cycle`, or is on its way there. Empty
/// if there is none.
std::optional<Step> step_at(const Cycles& cycles, std::size_t cycle, double tolerance_um);
/// The response to the largest step; the first one of several. `begin` becomes the cycle in which the
/// reference comes to rest.
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
  double mean_um_ = 0.0, sum_of_squares_ = 0.0;  ///< at the present level, around the mean
  double pooled_ = 0.0;                          ///< sum of squares of the former levels
  std::size_t samples_ = 0, pooled_samples_ = 0;
  std::size_t at_rest_ = 0;  ///< cycles of the present level
};

}  // namespace hystcan::metrics
