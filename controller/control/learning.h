// Learning for references that repeat: a correction c of the reference, with one value for each phase of a
// period. A phase is a cycle of the period.
//
// Plug-in repetitive control (Longman, Iterative learning control and repetitive control for engineering
// practice, Int. J. Control 73, 2000). The corrected reference r + c is the input of the feed-forward and of
// PI. The learnt error e is relative to r. Once in a cycle, the errors around a phase j of the period correct
// c[j]:
//
//   c[j] <- (1 - forget) c[j] + rate sum_k h_k e[j + k],    |c| <= bound,    k = -K .. K
//
//   h_k            learning filter with 2 K + 1 taps, nearly the inverse of the loop
//   rate, forget   share of the error that one period corrects; share of c that is lost in each period
//
// The filter also uses the errors up to K cycles later than phase j. So c[j] is corrected K cycles after
// phase j, in time for the next period. The error decays if, for all frequencies theta,
//
//   |1 - forget - rate H(theta) T(theta)| < 1
//
// T is the response of the loop to c, and H the response of the filter (docs/theory/control_law.md). The
// design in controller/analysis/learning_design.h satisfies this for a resonance that is not known exactly.
//
// If a period is not a whole number of cycles, several periods are learnt together, because their sum is
// nearly a whole number. The remaining difference stretches the phases slightly: c is interpolated between
// two phases, and a new correction is distributed to the two phases in the same way. At a share f of the way
// between two phases, this multiplies a frequency theta by
//
//   1 - 2 f (1 - f) (1 - cos theta)
//
// which weakens high frequencies and does not shift them.
//
// Only a complete window of errors of an undisturbed run is learnt: no transition, no first period, no lost
// sample, no omitted SYNC, no active limiter, and no glitch (an error far above the largest error without
// learning). Each segment is judged separately. If its error grows above its error without learning, its
// correction fades out, the segment rests for some periods, and learning restarts with half the factor
// `rate`. After the last attempt the segment is not corrected any more. If a correction ends, is reset or is
// withdrawn, it fades out and does not jump.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "base/words.h"
#include "controller/reference/trajectory.h"
#include "metrics/statistics.h"

namespace hystcan::controller {

enum class LearningState : std::uint8_t {
  off,       ///< learning is not configured, or no segment repeats
  learning,  ///< corrects, and learns while the run is undisturbed
  frozen,    ///< corrects, but does not learn
  diverged,  ///< the error of a segment grew in each attempt: its correction is withdrawn permanently
  resting    ///< the error of the last judged segment grew: no correction for some periods
};
constexpr auto words(LearningState) {
  return std::to_array<std::string_view>({"off", "learning", "frozen", "diverged", "resting"});
}
constexpr std::string_view to_string(LearningState state) { return word_of(state); }

class Learning {
 public:
  /// The learning filter of one segment of the reference. If `taps` is empty, the segment does not repeat.
  struct Plan {
    std::size_t phases = 0;  ///< number of cycles of one period, or of several periods together
    double cycle_s = 1e-3;
    double period_s = 0.0;       ///< duration of all phases; 0: `phases` times cycle_s
    std::size_t judged = 0;      ///< cycles over which one RMS error is computed; 0: `phases`
    std::vector<double> taps{};  ///< filter coefficients; their number is odd, at most `phases`
    double duration_s = 0.0;     ///< duration of the segment
  };
  /// Settings of the user, and the plans designed from them.
  struct Config {
    double rate = 0.5;               ///< share of the error that one period corrects; above 0, at most 1
    double forget_percent = 0.2;     ///< share of the correction that is lost in each period
    double correction_max_um = 0.0;  ///< maximum absolute value of a correction
    /// The filter also works if the resonance differs from the configured one by up to this percentage.
    double resonance_percent = 10.0;
    bool frozen = false;           ///< corrects with the learnt values, but does not learn
    std::size_t ahead_cycles = 0;  ///< number of cycles by which the feed-forward uses a correction early
    std::vector<Plan> plans{};  ///< one plan for each segment; plan_learning() designs ahead_cycles and plans
  };
  struct Report {
    LearningState state = LearningState::off;
    std::uint32_t periods = 0;  ///< number of judged periods of all segments since the last reset
    std::size_t segment = 0;    ///< index of the segment that was judged last
    double rms_um = 0.0;        ///< RMS error in the last judged period
    /// RMS error of this segment without learning: in its first judged period or, after a failed attempt to
    /// learn, in the last period of the pause without correction.
    double first_rms_um = 0.0;
    double correction_um = 0.0;      ///< present correction
    double correction_max_um = 0.0;  ///< largest correction of `segment` at the end of the judged period
  };

  /// Throws std::invalid_argument if the learning filter of a segment has an even number of taps, or more
  /// taps than the period has phases. The number must be odd, because the filter is centred on one phase.
  explicit Learning(const Config& config);

  const Config& config() const { return config_; }
  std::size_t ahead_cycles() const { return config_.ahead_cycles; }

  /// True if this point is in a segment that repeats.
  bool covers(const Trajectory::Point& point) const;

  /// The corrections of one cycle: at the point of the reference that the sample shows (`now_um`), and at the
  /// point that the feed-forward uses (`ahead_um`). correct() is called exactly once per cycle.
  struct Correction {
    double now_um = 0.0;
    double ahead_um = 0.0;
  };
  Correction correct(const Trajectory::Point& now, const Trajectory::Point& ahead, double dt_s);
  /// Learns from the error of a sample at this point; `nullopt`: the sample is lost. `undisturbed`: no
  /// limiter was active and no SYNC was omitted.
  void learn(const Trajectory::Point& point, std::optional<double> error_um, bool undisturbed);

  /// Clears all learnt corrections and judgements.
  void reset();
  /// Ends all corrections permanently; the present one fades out.
  void retire() { retired_ = true; }
  /// Copies from `before` the learnt corrections of each segment that has the same number of phases, and the
  /// present output. Does not allocate.
  void continue_from(const Learning& before);

  Report report() const;

  /// Returns the correction of each phase of each segment, to be saved. restore() accepts this table if the
  /// sizes agree.
  std::vector<std::vector<double>> table() const;
  bool restore(const std::vector<std::vector<double>>& table);

 private:
  /// A time between the two phases (cycles of the period) `index` and `next`. `share` is the elapsed share of
  /// the time from `index` to `next`, 0 to 1.
  struct Phase {
    std::size_t index, next;
    double share;
  };

  /// Judges whether the error of a segment is smaller with learning than without. Only periods that were
  /// undisturbed from start to end count.
  struct Judgement {
    metrics::ErrorStatistics present{};  ///< errors of the present period; a glitch counts only up to a limit
    bool is_known = false;               ///< true: first_rms_um and first_largest_um are set
    double first_rms_um = 0.0, first_largest_um = 0.0;  ///< RMS and largest error without learning
    unsigned grown = 0;    ///< consecutive periods with an RMS error above 1.3 times first_rms_um
    unsigned resting = 0;  ///< remaining periods without correction after a failed attempt
    unsigned failed = 0;   ///< number of attempts in which the error grew

    bool has_ended() const;
    bool is_idle() const;  ///< resting or ended: no correction and no learning
    bool is_glitch(double error_um) const;
  };

  struct Segment {
    Phase phase_at(double shape_time_s) const;
    std::size_t after(std::size_t index) const { return index + 1 < correction_um.size() ? index + 1 : 0; }

    std::vector<double> correction_um;
    double cycles_per_s = 0.0;
    double phases_per_s = 0.0;
    /// The taps of the learning filter in single precision. Single precision is twice as fast as double
    /// precision, and its rounding error is far below the noise.
    std::vector<float> taps;
    /// Ring buffer of the last errors, one for each tap. It contains each error twice, so that the errors
    /// from the oldest to the newest are always contiguous in memory.
    std::vector<float> errors_um;
    std::size_t newest = 0;
    /// Number of the newest errors that follow each other without a lost sample, a disturbance or a glitch,
    /// at most the number of taps.
    std::size_t valid = 0;
    std::size_t last_cycle = 0;  ///< cycle of the last error, counted from the start of the segment
    Judgement judgement;
  };

  /// The correction that is added to the reference. Its target is the learnt correction; there is no target
  /// outside segments that repeat, and while a segment rests. When a target begins or ends, the correction
  /// does not jump: its difference from the new target (0 without a target) fades out.
  struct Output {
    double last_um = 0.0;
    double fading_um = 0.0;  ///< remaining difference between the correction and its target
    bool follows = false;
    double step(const std::optional<double>& target_um, double decay);
  };

  const Plan* plan_at(const Trajectory::Point& point) const;
  std::optional<double> target_um(const Trajectory::Point& point) const;
  void interrupt();
  void take(std::size_t index, const Phase& phase, double error_um);
  void correct(Segment& segment, std::size_t phase, double share, double learnt_um);
  void tally(Segment& segment, const Plan& plan, double error_um);
  void conclude(Segment& segment);
  static void take_back(Segment& segment);

  Config config_;
  std::vector<Segment> segments_;
  Report report_;
  Output now_, ahead_;
  bool retired_ = false;
};

}  // namespace hystcan::controller
