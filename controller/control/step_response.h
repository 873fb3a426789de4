// How a stage arrives at the levels of a reference, and how quietly it stays there. Both classes take one
// sample a cycle, with the error e = r - y, and have constant memory.
//
//   StepResponse   a step is the move from one resting level a of the reference to the next one b. Time counts from the
//                  cycle in which the reference comes to rest at b, until the reference leaves it:
//
//                    band             band_um; where that is 0, 1 % of |b - a|
//                    settling time    until e is inside the band and leaves it no more; a step that ends outside has
//                                     not settled
//                    overshoot        max((y - b) sign(b - a), 0) / |b - a|
//
//   HoldNoise      the RMS of y around its mean at each level, over all levels. A level counts from the cycle in which
//                  e is inside the band, and again from the start where e leaves it. With band 0 everything counts
#pragma once

#include <cstddef>
#include <optional>

namespace hystcan::controller {

class StepResponse {
 public:
  struct Result {
    std::size_t steps = 0;
    std::size_t not_settled = 0;
    double settling_s = 0.0;  ///< the longest of those that have settled
    double overshoot = 0.0;   ///< the largest, as a share of its step
  };

  explicit StepResponse(double band_um) : band_um_(band_um) {}

  /// `time_s` is of any origin; `at_rest`: the reference does not move.
  void add(double time_s, double reference_um, double position_um, bool at_rest);
  /// The reference leaves this part of its path: the step ends, and the next level is the first one again.
  void leave();

  /// The present step, as far as it has come, counts.
  Result result() const;
  /// Of the present level; 0: there was no step to it.
  double band_um() const { return step_ ? step_->band_um : 0.0; }

 private:
  struct Step {
    double from_um = 0.0, to_um = 0.0, band_um = 0.0;
    double begin_s = 0.0, settled_s = 0.0;  ///< settled_s: since then inside the band
    double overshoot_um = 0.0;
    bool is_inside = false;
  };
  static void count(const Step& step, Result& result);

  double band_um_;
  std::optional<double> level_um_;  ///< where the reference rested last
  std::optional<Step> step_;
  Result finished_;
};

class HoldNoise {
 public:
  void add(double reference_um, double position_um, double band_um, bool at_rest);
  void leave();
  std::size_t samples() const { return pooled_samples_ + samples_; }
  double rms_um() const;

 private:
  double level_um_ = 0.0;
  double mean_um_ = 0.0, sum_of_squares_ = 0.0;  ///< at the present level, around the mean
  double pooled_ = 0.0;                          ///< sum of squares of the former levels
  std::size_t samples_ = 0, pooled_samples_ = 0;
};

}  // namespace hystcan::controller
