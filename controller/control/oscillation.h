// Detects an unstable loop: an oscillation of the error e = r - y (reference minus measured) that grows, or
// that stays large.
//
// A half-period k is the motion of e from one turning point to the next; k = 0 is the newest. A turn counts
// only if e has moved back by more than T/32, so that smaller noise makes no turn, and by more than an eighth
// of the previous pair of half-periods.
//
//   T      `amplitude_um`, the amplitude above which an oscillation counts
//   s_k    swing (peak to peak) of half-period k
//   p_j    swing of pair j, p_j = max(s_(2j), s_(2j+1)),  j = 0, 1, ...; p_j varies less than a single s_k,
//          because a sample rarely hits a peak
//
//   grows   p_0 >= 2 T,  p_1 >= 2 T / 8,   and either p_0 > p_1 > p_2 > p_3 with p_0 > 4 p_3,
//           or p_0 > p_1 > ... > p_7 with p_0 > 1.5 p_7
//   stays   p_j >= 2 T for j = 0..7,       max(p_0..p_3) >= 0.95 max(p_4..p_7)
//
// The loop is unstable if one of the two lines holds. "stays" finds slow growth, and the limit cycle in which
// growth ends at the limits of the drive. After a knock, a step or a corner, the mode of a stable loop decays
// by e^(-pi damping) in each half-period. For a damping of 0.002 or more, this is too fast for "stays".
//
// A spike of the sensor is not an oscillation: the spike is short, but the time to the next spike is long.
// Therefore the half-periods must have similar lengths. The length of a half-period is the number of its
// cycles in which e is beyond the middle of the half-period before. The longest half-period may have at most
// four times the length of the shortest, plus one cycle. If every half-period is longer than a spike, this
// limit holds separately for the half-periods with rising e and for those with falling e. A factor of 16 then
// limits the ratio of all lengths, because an oscillation at a limit of the drive is not symmetric.
//
// A pair of half-periods is forced if the reference itself bends so much that a lightly damped mode explains
// the error:
//
//   sum |e''| of the newest pair < 30 sum |r''| of this pair      '' : second difference from cycle to cycle
//
// If more than half of the pairs are forced, the loop is not judged: a sine or a chirp through a resonance
// makes a large error in a stable loop. A corner of a triangle forces only one pair. A step makes a mode
// ring, and its |r''| add up to twice its height. Therefore the loop is not judged either if the newest swing
// is less than 1.5 sum |r''| of all pairs.
//
// All times are counted in half-periods, so the rate does not matter. A step takes constant time and does not
// allocate.
#pragma once

#include <array>
#include <cstddef>

namespace hystcan::controller {

class Oscillation {
 public:
  /// `amplitude_um`: amplitude above which an oscillation counts. If it is infinite, the loop is not judged.
  explicit Oscillation(double amplitude_um) : amplitude_um_(amplitude_um) {}

  void restart() { *this = Oscillation(amplitude_um_); }
  /// Called once in each cycle with a sample, in closed loop. Returns true if the loop is unstable.
  bool step(double reference_um, double position_um);

 private:
  struct HalfPeriod {
    /// Length of the half-period: number of its cycles in which the error is beyond the mean of the errors at
    /// the two ends of the previous half-period.
    std::size_t cycles = 0;
    double swing_um = 0.0;
    /// Sum of the |second differences| of the reference, taken from cycle to cycle in this half-period.
    double reference_bend_um = 0.0;
    /// Sum of the |second differences| of the error, taken from cycle to cycle in this half-period.
    double error_bend_um = 0.0;
  };
  /// Sums the absolute second differences of a signal from cycle to cycle.
  struct Bend {
    double last_um = 0.0, last_step_um = 0.0, sum_um = 0.0;
    void add(double value_um);
  };
  static constexpr std::size_t kept = 16;

  bool turns(double error_um);
  void close(double swing_um);
  const HalfPeriod& ago(std::size_t k) const { return past_[(newest_ + kept - k) % kept]; }
  double pair_um(std::size_t j) const;
  double error_bend_um(std::size_t pair) const;
  double reference_bend_um(std::size_t pair) const;
  bool grows(std::size_t pairs) const;
  bool stays() const;
  bool is_even(std::size_t half_periods) const;
  bool is_forced(std::size_t half_periods) const;

  double amplitude_um_;
  Bend reference_, error_;
  std::array<HalfPeriod, kept> past_{};
  std::size_t newest_ = 0, closed_ = 0;
  std::size_t cycles_ = 0;   ///< number of cycles of this half-period with the error beyond middle_um_
  double middle_um_ = 0.0;   ///< middle between the errors at both ends of the last half-period
  unsigned samples_ = 0;     ///< number of samples so far, at most 3; the first three samples are not judged
  double turn_um_ = 0.0;     ///< error at the last turning point
  double extreme_um_ = 0.0;  ///< highest or lowest error since the last turning point
  bool rises_ = true;
};

}  // namespace hystcan::controller
