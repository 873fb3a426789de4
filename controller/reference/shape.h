// The shapes that a reference consists of. A shape is a position over time, with its velocity and
// acceleration.
//
// A shape begins at the time t = 0. Before t = 0 it has its first value, and after its end it has its last
// value. These shapes have corners or jumps: Ramp, Step, a Staircase without a rise, and a Triangle or Raster
// without a turnaround. All other shapes begin and end at rest; a Sine or a Triangle only if its number of
// cycles is whole.
//
// Chirp and MultiSine oscillate around a centre. Their envelope w fades in and out along the smooth step:
//
//   chirp        r(t) = centre + w(t) A sin(phi(t - fade_s))
//                phi(tau) = 2 pi (f_0 tau + (f_1 - f_0) tau^2 / (2 T))
//   multi-sine   r(t) = centre + w(t) sum_k a_k cos(2 pi f_k (t - fade_s) + phi_k)
//
//   r                 position
//   w                 rises from 0 to 1 within fade_s, is 1 for duration_s, and falls to 0 within fade_s
//   T                 duration_s
//   A, f_0, f_1       amplitude, first and last frequency of the chirp; the frequency is constant in a fade
//   a_k, f_k, phi_k   amplitude, frequency and phase of sine k
//
// If the configuration gives no phases, phi_k are Schroeder's phases, which keep the peak of the sum low (M.
// R. Schroeder, "Synthesis of low-peak-factor signals and binary sequences with low autocorrelation", IEEE
// Trans. Inf. Theory 16, 1970). p_j is the share of sine j in the power:
//
//   phi_k = -2 pi sum_{j<k} (k - j) p_j,     p_j = a_j^2 / sum of all a^2
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "controller/reference/motion.h"
#include "controller/reference/raster.h"

namespace hystcan::controller {

struct Hold {
  double level_um = 0.0;
  double duration_s = 1.0;
};

/// Rests at `from_um`, jumps to `to_um`, rests there, jumps back, and so on: `steps` jumps with a rest of
/// `dwell_s` before, between and after the jumps. After an odd number of jumps it ends at `to_um`.
struct Step {
  double from_um = 0.0;
  double to_um = 1.0;
  double dwell_s = 1.0;
  unsigned steps = 1;
};

struct Ramp {
  double from_um = 0.0;
  double to_um = 0.0;
  double duration_s = 1.0;
};

/// Moves from `low_um` up to `high_um` and back, `cycles` times. A turnaround (motion.h) rounds each of the
/// two corners of a cycle. Both turnarounds together take `turnaround_percent` of the period, half of this
/// before and half of it after the corners.
struct Triangle {
  double low_um = 0.0;
  double high_um = 1.0;
  double frequency_Hz = 1.0;
  double cycles = 1.0;
  double turnaround_percent = 0.0;
  double mode_period_s = 0.0;  ///< period of the stage's vibration mode, for the turnarounds; 0: no mode
};
/// Returns the sawtooth that a triangle with turnarounds follows. Its time 0 is the beginning of the
/// triangle.
Sawtooth rounded(const Triangle& triangle);

/// Like Triangle, but each cycle is a sine: the position follows (1 - cos) / 2 between `low_um` and
/// `high_um`.
struct Sine {
  double low_um = 0.0;
  double high_um = 1.0;
  double frequency_Hz = 1.0;
  double cycles = 1.0;
};

/// Oscillates between `low_um` and `high_um`; the frequency changes linearly from `from_Hz` to `to_Hz`.
struct Chirp {
  double low_um = 0.0;
  double high_um = 1.0;
  double from_Hz = 1.0;
  double to_Hz = 10.0;
  double duration_s = 1.0;
  double fade_s = 0.1;
};

struct MultiSine {
  double centre_um = 0.0;
  std::vector<double> amplitudes_um;
  std::vector<double> frequencies_Hz;
  std::vector<double> phases_deg{};  ///< phase of each sine; empty: prepared() sets Schroeder's phases
  double duration_s = 1.0;
  double fade_s = 0.1;
};

/// Visits `levels_um` in order: moves to each level within `rise_s` (0: jumps), then rests there for
/// `dwell_s`.
struct Staircase {
  std::vector<double> levels_um;
  double rise_s = 0.0;
  double dwell_s = 0.1;
};

/// A position over time, from the rows of a CSV file. The time t = 0 is the time in the first row.
struct Table {
  std::string file;
  MonotoneCubic curve;
};

using Shape = std::variant<Hold, Step, Ramp, Triangle, Sine, Chirp, MultiSine, Staircase, Table, Raster>;

/// The names of all shapes in the configuration, in the order of the alternatives of Shape.
inline constexpr std::array<std::string_view, std::variant_size_v<Shape>> shape_kinds{
    "hold", "step", "ramp", "triangle", "sine", "chirp", "multi-sine", "staircase", "csv", "raster"};
/// Returns the name of the kind of this shape, one of shape_kinds.
std::string to_string(const Shape& shape);
/// Returns a shape of this kind with its defaults; `kind` is one of shape_kinds.
Shape shape_of_kind(std::string_view kind);
/// Computes the members of the shape that depend on its other members: the phases of a MultiSine, and `wave`
/// and `way_up_s` of a Raster. Returns the completed shape. Throws std::invalid_argument if the parameters
/// contradict each other.
Shape prepared(Shape shape);
double duration_s(const Shape& shape);
/// Returns the position `t_s` seconds after the shape's beginning. Only a shape that prepared() has returned
/// may be passed to value_um() and to the functions below it in this file.
double value_um(const Shape& shape, double t_s);
/// True for a triangle or raster whose corners are rounded by turnarounds.
bool has_turnarounds(const Shape& shape);
/// Returns the position with sharp corners instead of rounded ones (turnarounds). Equals value_um() for a
/// shape without turnarounds.
double ideal_um(const Shape& shape, double t_s);
/// Returns position, velocity and acceleration at `t_s`. At a corner or a jump, returns the motion after the
/// corner or jump.
Motion motion(const Shape& shape, double t_s);
/// Returns the present frame, line and pixel of a raster scan. Returns `nullopt` outside the lines of the
/// raster, and for any other shape.
std::optional<ScanPlace> place_in_scan(const Shape& shape, double t_s);
/// True if the position does not change at `t_s`: in a Hold, at the levels of a Step, during the dwell of a
/// Staircase, at the levels of a raster's slow axis, and after the end of every other shape.
bool rests(const Shape& shape, double t_s);

/// Returns the range, the maximum velocity and the maximum acceleration of a prepared shape. Corners and
/// jumps do not count as motion. The values are exact, with two exceptions. For a chirp, velocity and
/// acceleration are upper bounds, because they assume the worst phase of the sine during the fades. A
/// multi-sine is evaluated at 64 points per shortest period, which is accurate to 0.2 % of its amplitudes. If
/// this needs more than a million points, its values are upper bounds, as if all sines had their worst phase
/// at the same time.
MotionBounds motion_bounds(const Shape& shape);

}  // namespace hystcan::controller
