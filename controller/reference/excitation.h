// The drive of a measurement in open loop: a known function of time. The dataset of such a measurement serves
// to identify an actuator.
//
//   hysteresis   straight ramps of constant slew between turning points, with a rest at each turning point.
//                The drive begins and ends at `low` and visits, in this order:
//                  major loops      low -> high -> low, `loops` times
//                  nested loops     middle +- a_k (high - low) / 2,  a_k = 1 - k / (levels + 1), for loops
//                                   k = 1 .. levels. Each loop is inside the loop before; the way to `high`
//                                   closes all of them
//                  reversal curves  high -> r_j -> high,  r_j = low + (high - low) j / (levels + 1),
//                                   for j = levels .. 1; then low -> r_j -> low, for j = 1 .. levels
//   steps        centre - amplitude <-> centre + amplitude, half a period each, `cycles` times; half a period
//                at the centre before and after
//   chirp        centre + amplitude sin(2 pi (f_0 t + (f_1 - f_0) t^2 / (2 T))),  0 <= t <= T; T: duration,
//                f_0, f_1: first and last frequency
//
// Drives are in drive units, times in s. A rest must last two cycles or more. Without a rest, a turning point
// could be between two cycles, and no row of the dataset would show it. Before the beginning and after the
// end, the drive is constant.
#pragma once

#include <string_view>
#include <variant>
#include <vector>

#include "model/reference_curve.h"

namespace hystcan::controller {

class Excitation {
 public:
  /// Maximum number of loops, levels or cycles.
  static constexpr unsigned most_turns = 10'000;

  struct Hysteresis {
    double low = 0.0;
    double high = 100.0;
    double slew_per_s = 100.0;
    double rest_s = 0.01;
    unsigned loops = 2;
    unsigned levels = 5;
  };
  struct Steps {
    double centre = 50.0;
    double amplitude = 5.0;
    double period_s = 0.4;
    unsigned cycles = 5;
  };
  struct Chirp {
    double centre = 50.0;
    double amplitude = 5.0;
    double from_Hz = 1.0;
    double to_Hz = 400.0;
    double duration_s = 10.0;
  };
  using Config = std::variant<Hysteresis, Steps, Chirp>;

  /// Throws std::invalid_argument if a parameter is out of range, or if the drive lasts longer than 1e6 s.
  explicit Excitation(const Config& config);

  double at(double t_s) const;
  double length_s() const { return length_s_; }
  model::Interval range() const;
  /// Returns the maximum slope of the drive, in drive units per s. Returns 0 for steps, because the gate
  /// limits their slew.
  double steepest_per_s() const;

 private:
  struct Knot {
    double time_s = 0.0;
    double drive = 0.0;
  };
  void hold(double drive, double duration_s);
  void add_knots(const Hysteresis& h);
  void add_knots(const Steps& s);
  void add_knots(const Chirp& c);

  Config config_;
  std::vector<Knot> knots_;  ///< points of the drive, connected by straight lines; empty for a chirp
  double length_s_ = 0.0;
};

std::string_view name_of(const Excitation::Config& config);

/// Returns the time from the beginning of the drive until it is back at `low`, after the first major loop.
double loop_s(const Excitation::Hysteresis& h);

/// Returns all turning points of the drive in the order of time, including the first and the last value.
std::vector<double> turning_points(const Excitation::Hysteresis& h);

/// Throws std::invalid_argument if the drive leaves `range` or is steeper than `slew_per_s`.
void refuse_beyond(const model::Interval& range, double slew_per_s, const Excitation& excitation);

}  // namespace hystcan::controller
