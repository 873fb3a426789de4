// Learning for references that repeat: a correction c of the reference for each phase of a period.
//
// Plug-in repetitive control (Longman, Iterative learning control and repetitive control for engineering
// practice, Int. J. Control 73, 2000). The corrected reference r + c drives the feed-forward and is what PI
// compares with; the error is that of r. Once a cycle, one phase j of the period is corrected by the errors
// around it:
//
//   c[j] <- (1 - forget) c[j] + rate sum_k h_k e[j + k],    |c| <= bound,    k = -K .. K
//
// h is nearly the inverse of the loop and non-causal, so phase j is corrected K cycles after it has passed,
// in time for the next period. With T the loop's response to c and H that of h
// (docs/theory/control_law.md), the error decays where
//
//   |1 - forget - rate H(theta) T(theta)| < 1        for all theta
//
// controller/analysis/learning_design.h finds an h that keeps this for a resonance that is not known exactly.
//
// Phases are cycles. Where a period is not a whole number of them, few periods together nearly are; what is
// left over stretches the phases a little: c is interpolated between two of them, and what is learnt is
// shared out to the two in the same way. Between phases this weakens high frequencies, by 1 - 2 f (1 - f) (1
// - cos theta), and shifts none.
//
// It learns from nothing but a whole window of errors of an undisturbed run: no transition, no first period,
// no lost sample, no SYNC that was left out, no limiter, no error far beyond those of the first period, which
// is a glitch. Each segment is judged by itself. Where its error grows beyond what it was without learning,
// its correction fades out, the segment rests for some periods, and learning begins again at half the rate;
// the last attempt ends it for good. A correction that ends, is reset or is taken back fades out: it does not
// jump.
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
  off,       ///< not configured, or no segment repeats
  learning,  ///< corrects, and learns where the run is undisturbed
  frozen,    ///< corrects, does not learn
  diverged,  ///< the error of a segment grew in each attempt: its correction has been taken back for good
  resting    ///< the error of the segment that was judged last grew: no correction for some periods
};
constexpr auto words(LearningState) {
  return std::to_array<std::string_view>({"off", "learning", "frozen", "diverged", "resting"});
}
constexpr std::string_view to_string(LearningState state) { return word_of(state); }

class Learning {
 public:
  /// The filter of one segment; no taps: the segment does not repeat.
  struct Plan {
    std::size_t phases = 0;  ///< cycles of a period, or of a few periods together
    double cycle_s = 1e-3;
    double period_s = 0.0;       ///< of all phases; 0: phases cycles
    std::size_t judged = 0;      ///< cycles whose errors are judged together; 0: phases
    std::vector<double> taps{};  ///< h, from -K on; 2 K + 1 of them, fewer than phases
    double duration_s = 0.0;     ///< of the segment
  };
  /// What the user states.
  struct Config {
    double rate = 0.5;                ///< share of the error that a period corrects, > 0 to 1
    double forget_percent = 0.2;      ///< of the correction, per period
    double correction_max_um = 0.0;   ///< bound
    double resonance_percent = 10.0;  ///< the filter is designed for a resonance that is this far off
    bool frozen = false;              ///< corrects with what it has learnt, and learns no more
    std::size_t ahead_cycles = 0;     ///< of the correction in the feed-forward
    std::vector<Plan> plans{};        ///< one for each segment; ahead_cycles and plans are designed
  };
  struct Report {
    LearningState state = LearningState::off;
    std::uint32_t periods = 0;  ///< judged since the last reset, of all segments
    std::size_t segment = 0;    ///< of the last one
    double rms_um = 0.0;        ///< error of the last one
    double first_rms_um = 0.0;  ///< of its segment without learning: in the first period, or in the last rest
    double correction_um = 0.0;      ///< at present
    double correction_max_um = 0.0;  ///< the largest of its segment, at its end
  };

  /// Throws std::invalid_argument where a plan contradicts itself.
  explicit Learning(const Config& config);

  const Config& config() const { return config_; }
  std::size_t ahead_cycles() const { return config_.ahead_cycles; }

  /// False: the time of this point is beyond what repeats, so that only the trajectory knows where it is.
  bool covers(const Trajectory::Point& point) const;

  /// c of a cycle, at the points of its sample and of its feed-forward. Called exactly once per cycle.
  struct Correction {
    double now_um = 0.0;
    double ahead_um = 0.0;
  };
  Correction correct(const Trajectory::Point& now, const Trajectory::Point& ahead, double dt_s);
  /// Learns from the error of a sample at this point. `undisturbed`: no limiter was active and no SYNC was
  /// left out. Empty: the sample is lost.
  void learn(const Trajectory::Point& point, std::optional<double> error_um, bool undisturbed);

  /// Forgets all that was learnt.
  void reset();
  /// Ends the correction, for good.
  void retire() { retired_ = true; }
  /// Takes over what `before` has learnt where its segments repeat alike, and what it puts out at present.
  /// Does not allocate.
  void continue_from(const Learning& before);

  Report report() const;

  /// The correction of each phase of each segment; to be saved, and restored where the sizes agree.
  std::vector<std::vector<double>> table() const;
  bool restore(const std::vector<std::vector<double>>& table);

 private:
  /// A time lies this share of the way from one phase to the next.
  struct Phase {
    std::size_t index, next;
    double share;
  };

  /// What the errors of a segment were in the periods that were undisturbed from end to end.
  struct Judgement {
    metrics::ErrorStatistics present{};  ///< of the present period; a glitch counts less in its square
    bool is_known = false;               ///< what follows
    double first_rms_um = 0.0, first_largest_um = 0.0;  ///< of the period without learning
    unsigned grown = 0;    ///< periods in a row with a larger error than that one
    unsigned resting = 0;  ///< periods that are left of a rest
    unsigned failed = 0;   ///< attempts in which the error grew

    bool has_ended() const;
    bool is_idle() const;  ///< rests, or has ended: no correction, nothing is learnt
    bool is_glitch(double error_um) const;
  };

  struct Segment {
    Phase phase_at(double shape_time_s) const;
    std::size_t after(std::size_t index) const { return index + 1 < correction_um.size() ? index + 1 : 0; }

    std::vector<double> correction_um;
    double cycles_per_s = 0.0;
    double phases_per_s = 0.0;
    std::vector<float> taps;       ///< h; single precision is far below the noise, and twice as fast
    std::vector<float> errors_um;  ///< the last ones, twice, so that each window lies in one piece
    std::size_t newest = 0;
    std::size_t valid = 0;       ///< errors without a gap
    std::size_t last_cycle = 0;  ///< since the segment's beginning
    Judgement judgement;
  };

  /// A correction that is put out.
  struct Output {
    double last_um = 0.0;
    double fading_um = 0.0;  ///< what is left of a jump
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
