// What a reference may do: shapes over time, each with its value, velocity and acceleration.
//
// A shape begins at t = 0 and is held at both of its ends. Triangle, Ramp, Step and a Staircase without a
// rise have corners or jumps: these are what the user asked for. All others begin and end at rest, a Sine
// where its cycles are whole.
//
// Chirp, MultiSine: about a centre, with an envelope w that fades in and out along the smooth step,
//
//   r(t) = centre + w(t) A sin(phi(t - fade_s)),     phi(tau) = 2 pi (f_0 tau + (f_1 - f_0) tau^2 / 2 T)
//   r(t) = centre + w(t) sum_k a_k cos(2 pi f_k (t - fade_s) + phi_k)
//
// full for duration_s = T; the fades come before and after that. While it fades, a chirp keeps its first and
// its last frequency. The default of phi_k keeps the peak low (M. R. Schroeder, "Synthesis of low-peak-factor
// signals and binary sequences with low autocorrelation", IEEE Trans. Inf. Theory 16, 1970):
//
//   phi_k = -2 pi sum_{j<k} (k - j) p_j,     p_j = a_j^2 / sum of all a^2
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "controller/reference/monotone_cubic.h"

namespace hystcan::controller {

struct Hold {
  double level_um = 0.0;
  double duration_s = 1.0;
};

/// Rests at `from_um`, goes to `to_um` at once, rests there, and so on: `steps` steps, `dwell_s` before,
/// between and after them. An odd number ends at `to_um`.
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

/// From `low_um` up to `high_um` and back, `cycles` times.
struct Triangle {
  double low_um = 0.0;
  double high_um = 1.0;
  double frequency_Hz = 1.0;
  double cycles = 1.0;
};

/// As Triangle, along (1 - cos) / 2.
struct Sine {
  double low_um = 0.0;
  double high_um = 1.0;
  double frequency_Hz = 1.0;
  double cycles = 1.0;
};

/// Between `low_um` and `high_um`, the frequency going linearly from `from_Hz` to `to_Hz`.
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
  std::vector<double> phases_deg{};  ///< empty: Schroeder's, filled in by prepared()
  double duration_s = 1.0;
  double fade_s = 0.1;
};

/// Level after level: `rise_s` to get there (0: a step), then `dwell_s`.
struct Staircase {
  std::vector<double> levels_um;
  double rise_s = 0.0;
  double dwell_s = 0.1;
};

/// The rows of a file, from its first time on.
struct Table {
  std::string file;
  MonotoneCubic curve;
};

using Shape = std::variant<Hold, Step, Ramp, Triangle, Sine, Chirp, MultiSine, Staircase, Table>;

struct Motion {
  double value_um = 0.0;
  double velocity_um_per_s = 0.0;
  double acceleration_um_per_s2 = 0.0;
};

/// The kinds of Shape in its order, as the configuration names them.
inline constexpr std::array<std::string_view, std::variant_size_v<Shape>> shape_kinds{
    "hold", "step", "ramp", "triangle", "sine", "chirp", "multi-sine", "staircase", "csv"};
/// Of this shape.
std::string to_string(const Shape& shape);
/// A shape of this kind with its defaults; `kind` is one of shape_kinds.
Shape shape_of_kind(std::string_view kind);
/// The shape with what was left open filled in. Throws std::invalid_argument where its numbers do not fit
/// together.
Shape prepared(Shape shape);
double duration_s(const Shape& shape);
/// At `t_s` seconds after the shape's beginning. Of a prepared shape; so the two below.
double value_um(const Shape& shape, double t_s);
/// At a corner and at a jump: of what comes after it.
Motion motion(const Shape& shape, double t_s);
/// The value does not change: a hold, a step's levels, the dwell of a staircase.
bool rests(const Shape& shape, double t_s);

/// The smooth step 10 s^3 - 15 s^4 + 6 s^5 (least jerk): 0 at s <= 0, 1 at s >= 1. Its greatest slope is
/// 15/8, its greatest curvature 10/sqrt(3).
double smooth_step(double s);
inline constexpr double smooth_step_peak_slope = 1.875;
inline constexpr double smooth_step_peak_curvature = 5.773502691896258;

}  // namespace hystcan::controller
