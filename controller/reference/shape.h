// The shapes of a reference over time, each with its value, velocity and acceleration.
//
// A shape begins at t = 0; it is held before its beginning and after its end. Ramp, Step, a Staircase without
// a rise, and a Triangle or Raster without a turnaround have corners or jumps, as the user requests. All
// others begin and end at rest; a Sine or a Triangle only if its number of cycles is whole.
//
// Chirp and MultiSine oscillate around a centre. Their envelope w fades in and out along the smooth step:
//
//   chirp        r(t) = centre + w(t) A sin(phi(t - fade_s))
//                phi(tau) = 2 pi (f_0 tau + (f_1 - f_0) tau^2 / 2 T)
//   multi-sine   r(t) = centre + w(t) sum_k a_k cos(2 pi f_k (t - fade_s) + phi_k)
//
// w is 1 for duration_s = T; the fades are before and after. During the fades a chirp keeps its first or its
// last frequency. The default of phi_k keeps the peak low (M. R. Schroeder, "Synthesis of low-peak-factor
// signals and binary sequences with low autocorrelation", IEEE Trans. Inf. Theory 16, 1970):
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
/// `dwell_s` before, between and after them. After an odd number of jumps it ends at `to_um`.
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

/// Moves from `low_um` up to `high_um` and back, `cycles` times. Its two turnarounds (motion.h) together take
/// `turnaround_percent` of the period: each takes half of this share, a quarter before its corner and a
/// quarter after it.
struct Triangle {
  double low_um = 0.0;
  double high_um = 1.0;
  double frequency_Hz = 1.0;
  double cycles = 1.0;
  double turnaround_percent = 0.0;
  double mode_period_s = 0.0;  ///< period of the stage's mode
};
/// Returns the sawtooth of a triangle with turnarounds; its time 0 is the beginning of the triangle.
Sawtooth rounded(const Triangle& triangle);

/// Like Triangle, but moves sinusoidally, along (1 - cos) / 2, instead of in straight lines.
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
  std::vector<double> phases_deg{};  ///< empty: Schroeder's phases, set by prepared()
  double duration_s = 1.0;
  double fade_s = 0.1;
};

/// At each level: a rise within `rise_s` (0: a step), then a rest of `dwell_s`.
struct Staircase {
  std::vector<double> levels_um;
  double rise_s = 0.0;
  double dwell_s = 0.1;
};

/// The rows of a file. Time 0 is the first time in the file.
struct Table {
  std::string file;
  MonotoneCubic curve;
};

using Shape = std::variant<Hold, Step, Ramp, Triangle, Sine, Chirp, MultiSine, Staircase, Table, Raster>;

/// The kinds of Shape in the order of its alternatives, by their names in the configuration.
inline constexpr std::array<std::string_view, std::variant_size_v<Shape>> shape_kinds{
    "hold", "step", "ramp", "triangle", "sine", "chirp", "multi-sine", "staircase", "csv", "raster"};
/// Returns the kind and parameters of this shape as text.
std::string to_string(const Shape& shape);
/// Returns a shape of this kind with its defaults; `kind` is one of shape_kinds.
Shape shape_of_kind(std::string_view kind);
/// Sets the defaults that depend on other members. Throws std::invalid_argument if the parameters contradict
/// each other.
Shape prepared(Shape shape);
double duration_s(const Shape& shape);
/// Returns the value `t_s` seconds after the shape's beginning. This and the next functions need a prepared
/// shape.
double value_um(const Shape& shape, double t_s);
/// True for a triangle or raster with rounded corners.
bool has_turnarounds(const Shape& shape);
/// Same as value_um(), with a sharp corner instead of each turnaround.
double ideal_um(const Shape& shape, double t_s);
/// Returns the motion. At a corner or a jump, this is the motion after it.
Motion motion(const Shape& shape, double t_s);
/// Returns the place in the scan of a raster; `nullopt` outside its lines, and for any other shape.
std::optional<ScanPlace> place_in_scan(const Shape& shape, double t_s);
/// True if the value is constant: a hold, a step's levels, the dwell of a staircase.
bool rests(const Shape& shape, double t_s);

/// Returns the bounds of a prepared shape. Peaks are those of the smooth parts: the corners of a ramp or
/// triangle and the jumps of a step do not count. Chirp: velocity and acceleration are an upper bound, for
/// the worst phase of the sine during the fades. Multi-sine: sampled with 64 points per shortest period, to
/// 0.2 % of its amplitudes. If this needs more than a million points: an upper bound, with all sines at their
/// worst phase at the same time.
MotionBounds motion_bounds(const Shape& shape);

}  // namespace hystcan::controller
