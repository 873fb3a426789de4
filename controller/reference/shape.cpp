#include "controller/reference/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <variant>

namespace hystcan::controller {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

double blend(double from, double to, double s) { return from + (to - from) * s; }

/// Returns the elapsed share of the present cycle, 0..1. After the last cycle, returns exactly 0 if the
/// number of cycles is whole.
template <class Periodic>
double phase(const Periodic& shape, double t_s) {
  const double cycles = std::clamp(t_s * shape.frequency_Hz, 0.0, shape.cycles);
  return cycles - std::floor(cycles);
}

template <class Periodic>
bool is_within(const Periodic& shape, double t_s) {
  return t_s >= 0.0 && t_s * shape.frequency_Hz < shape.cycles;
}

/// Returns the envelope w, a factor without unit, with its derivatives. It rises from 0 to 1 within the first
/// `fade_s`, is 1 for duration_s, and falls to 0 within the last `fade_s`.
template <class Fading>
Motion envelope(const Fading& shape, double t_s) {
  if (t_s < shape.fade_s + 0.5 * shape.duration_s) return smooth_rise(0.0, 1.0, t_s, shape.fade_s);
  Motion out = smooth_rise(0.0, 1.0, 2.0 * shape.fade_s + shape.duration_s - t_s, shape.fade_s);
  out.velocity_um_per_s = -out.velocity_um_per_s;
  return out;
}

/// Returns the motion centre + w x: an oscillation `x` in um, multiplied by an envelope `w` without unit. The
/// product rule gives the velocity and the acceleration.
Motion enveloped(double centre_um, const Motion& w, const Motion& x) {
  return {.value_um = centre_um + w.value_um * x.value_um,
          .velocity_um_per_s = w.velocity_um_per_s * x.value_um + w.value_um * x.velocity_um_per_s,
          .acceleration_um_per_s2 = w.acceleration_um_per_s2 * x.value_um +
                                    2.0 * w.velocity_um_per_s * x.velocity_um_per_s +
                                    w.value_um * x.acceleration_um_per_s2};
}

Motion motion_of(const Hold& s, double) { return {.value_um = s.level_um}; }

Motion motion_of(const Step& s, double t_s) {
  const double step = std::clamp(std::floor(t_s / s.dwell_s), 0.0, static_cast<double>(s.steps));
  return {.value_um = std::fmod(step, 2.0) == 0.0 ? s.from_um : s.to_um};
}

Motion motion_of(const Ramp& s, double t_s) {
  const bool within = t_s >= 0.0 && t_s < s.duration_s;
  return {.value_um = blend(s.from_um, s.to_um, std::clamp(t_s / s.duration_s, 0.0, 1.0)),
          .velocity_um_per_s = within ? (s.to_um - s.from_um) / s.duration_s : 0.0};
}

Motion motion_of(const Triangle& s, double t_s) {
  if (s.turnaround_percent > 0.0) {
    const double in_cycles_s = phase(s, t_s) / s.frequency_Hz;
    const Motion turning = rounded(s).at(in_cycles_s);
    return is_within(s, t_s) ? turning : Motion{.value_um = turning.value_um};
  }
  const double p = phase(s, t_s);
  const double slew = 2.0 * (s.high_um - s.low_um) * s.frequency_Hz;
  const double direction = p < 0.5 ? 1.0 : -1.0;
  return {.value_um = blend(s.low_um, s.high_um, 1.0 - std::abs(2.0 * p - 1.0)),
          .velocity_um_per_s = is_within(s, t_s) ? direction * slew : 0.0};
}

Motion motion_of(const Sine& s, double t_s) {
  const double angle = two_pi * phase(s, t_s);
  const double cosine = std::cos(angle);
  Motion motion{.value_um = blend(s.low_um, s.high_um, 0.5 * (1.0 - cosine))};
  if (!is_within(s, t_s)) return motion;
  const double omega = two_pi * s.frequency_Hz;
  const double amplitude_um = 0.5 * (s.high_um - s.low_um);
  motion.velocity_um_per_s = amplitude_um * omega * std::sin(angle);
  motion.acceleration_um_per_s2 = amplitude_um * omega * omega * cosine;
  return motion;
}

Motion motion_of(const Chirp& s, double t_s) {
  const double tau = t_s - s.fade_s;
  const double swept = std::clamp(tau, 0.0, s.duration_s);
  const double rate_Hz_per_s = (s.to_Hz - s.from_Hz) / s.duration_s;
  const double frequency_Hz = s.from_Hz + rate_Hz_per_s * swept;
  const double cycles = swept * (s.from_Hz + 0.5 * rate_Hz_per_s * swept) + (tau - swept) * frequency_Hz;
  const double angle = two_pi * (cycles - std::floor(cycles));
  const double omega = two_pi * frequency_Hz;
  const double change = swept == tau ? two_pi * rate_Hz_per_s : 0.0;
  const double amplitude_um = 0.5 * (s.high_um - s.low_um);
  const double sine = std::sin(angle);
  const double cosine = std::cos(angle);
  return enveloped(0.5 * (s.low_um + s.high_um), envelope(s, t_s),
                   {.value_um = amplitude_um * sine,
                    .velocity_um_per_s = amplitude_um * omega * cosine,
                    .acceleration_um_per_s2 = amplitude_um * (change * cosine - omega * omega * sine)});
}

Motion motion_of(const MultiSine& s, double t_s) {
  Motion sum;
  for (std::size_t k = 0; k < s.amplitudes_um.size(); ++k) {
    const double omega = two_pi * s.frequencies_Hz[k];
    const double angle = omega * (t_s - s.fade_s) + s.phases_deg[k] * std::numbers::pi / 180.0;
    const double cosine = s.amplitudes_um[k] * std::cos(angle);
    sum.value_um += cosine;
    sum.velocity_um_per_s -= omega * s.amplitudes_um[k] * std::sin(angle);
    sum.acceleration_um_per_s2 -= omega * omega * cosine;
  }
  return enveloped(s.centre_um, envelope(s, t_s), sum);
}

Motion motion_of(const Staircase& stairs, double t_s) {
  const double step_s = stairs.rise_s + stairs.dwell_s;
  const double last = static_cast<double>(stairs.levels_um.size() - 1);
  const double step = std::clamp(std::floor(t_s / step_s), 0.0, last);
  const auto i = static_cast<std::size_t>(step);
  if (i == 0 || stairs.rise_s == 0.0) return {.value_um = stairs.levels_um[i]};
  return smooth_rise(stairs.levels_um[i - 1], stairs.levels_um[i], t_s - step * step_s, stairs.rise_s);
}

Motion motion_of(const Table& s, double t_s) { return s.curve.at(t_s); }

double ideal_of(const Triangle& s, double t_s) {
  if (s.turnaround_percent == 0.0 || !is_within(s, t_s)) return motion_of(s, t_s).value_um;
  return rounded(s).ideal_um(phase(s, t_s) / s.frequency_Hz);
}
template <class Plain>
double ideal_of(const Plain& s, double t_s) {
  return motion_of(s, t_s).value_um;
}

double duration_of(const Step& s) { return (s.steps + 1.0) * s.dwell_s; }
double duration_of(const Triangle& s) { return s.cycles / s.frequency_Hz; }
double duration_of(const Sine& s) { return s.cycles / s.frequency_Hz; }
double duration_of(const Chirp& s) { return s.duration_s + 2.0 * s.fade_s; }
double duration_of(const MultiSine& s) { return s.duration_s + 2.0 * s.fade_s; }
double duration_of(const Staircase& s) {
  return static_cast<double>(s.levels_um.size()) * (s.rise_s + s.dwell_s);
}
double duration_of(const Table& s) { return s.curve.length(); }
double duration_of(const Raster& s) { return s.duration_s(); }
template <class Plain>
double duration_of(const Plain& s) {
  return s.duration_s;
}

bool rests_in(const Hold&, double) { return true; }
bool rests_in(const Step&, double) { return true; }
bool rests_in(const Staircase& stairs, double t_s) {
  const double step_s = stairs.rise_s + stairs.dwell_s;
  return t_s < step_s || t_s - std::floor(t_s / step_s) * step_s >= stairs.rise_s;
}
template <class Moving>
bool rests_in(const Moving& s, double t_s) {
  return t_s >= duration_of(s);
}

std::vector<double> schroeder_phases_deg(const std::vector<double>& amplitudes_um) {
  double power = 0.0;
  for (const double a : amplitudes_um) power += a * a;
  std::vector<double> phases_deg;
  phases_deg.reserve(amplitudes_um.size());
  double before = 0.0;  // power share of the sines before k: sum_{j<k} p_j (shape.h)
  double sum = 0.0;
  for (const double a : amplitudes_um) {
    sum += before;
    phases_deg.push_back(-360.0 * (sum - std::floor(sum)));
    before += a * a / power;
  }
  return phases_deg;
}

void prepare(MultiSine& s) {
  if (s.amplitudes_um.size() != s.frequencies_Hz.size())
    throw std::invalid_argument("a multi-sine has " + std::to_string(s.frequencies_Hz.size()) +
                                " frequencies, expected " + std::to_string(s.amplitudes_um.size()) +
                                ", one frequency for each amplitude");
  if (s.phases_deg.empty()) s.phases_deg = schroeder_phases_deg(s.amplitudes_um);
  if (s.phases_deg.size() != s.amplitudes_um.size())
    throw std::invalid_argument("a multi-sine has " + std::to_string(s.phases_deg.size()) +
                                " phases, expected " + std::to_string(s.amplitudes_um.size()) +
                                ", one phase for each amplitude, or no phases");
}

/// Returns the alternative of Shape with this index, with default parameters.
template <std::size_t i = 0>
Shape default_shape(std::size_t index) {
  if constexpr (i + 1 < std::variant_size_v<Shape>) {
    if (index != i) return default_shape<i + 1>(index);
  }
  return Shape(std::in_place_index<i>);
}

MotionBounds between(double from_um, double to_um) {
  return {.lowest_um = std::min(from_um, to_um), .highest_um = std::max(from_um, to_um)};
}

/// Adds the maximum velocity and acceleration of a sine that fades in within `fade_s`. Each maximum is the
/// amplitude times the largest length of a vector during the fade. w, w', w'' are the envelope and its
/// derivatives; omega and omega' are the angular frequency and its change:
///   velocity      (w', w omega)
///   acceleration  (w'' - w omega^2, 2 w' omega + w omega')
void add_faded(MotionBounds& bounds, double amplitude_um, double frequency_Hz, double chirp_Hz_per_s,
               double fade_s) {
  constexpr int points = 500;
  const double omega = 2.0 * std::numbers::pi * frequency_Hz;
  const double omega_change = 2.0 * std::numbers::pi * std::abs(chirp_Hz_per_s);
  double slew = 0.0;
  double acceleration = 0.0;
  for (int i = 0; i <= points; ++i) {
    const double s = static_cast<double>(i) / points;
    const double w = smooth_step(s);
    const double slope = 30.0 * s * s * (1.0 - s) * (1.0 - s) / fade_s;
    const double curvature = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (fade_s * fade_s);
    slew = std::max(slew, std::hypot(slope, w * omega));
    acceleration = std::max(
        acceleration, std::hypot(curvature - w * omega * omega, 2.0 * slope * omega + w * omega_change));
  }
  bounds.peak_slew_um_per_s += amplitude_um * slew;
  bounds.peak_acceleration_um_per_s2 += amplitude_um * acceleration;
}

MotionBounds motion_bounds_of(const Hold& s) { return between(s.level_um, s.level_um); }
MotionBounds motion_bounds_of(const Step& s) { return between(s.from_um, s.to_um); }

MotionBounds motion_bounds_of(const Ramp& s) {
  MotionBounds bounds = between(s.from_um, s.to_um);
  bounds.peak_slew_um_per_s = (bounds.highest_um - bounds.lowest_um) / s.duration_s;
  return bounds;
}

MotionBounds motion_bounds_of(const Triangle& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  bounds.peak_slew_um_per_s = 2.0 * s.frequency_Hz * (bounds.highest_um - bounds.lowest_um);
  if (s.turnaround_percent == 0.0) return bounds;
  const Sawtooth wave = rounded(s);
  bounds.peak_slew_um_per_s = wave.peak_slew_um_per_s();
  bounds.peak_acceleration_um_per_s2 = wave.peak_acceleration_um_per_s2();
  return bounds;
}

MotionBounds motion_bounds_of(const Raster& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  const Motion peak = peak_motion(s);
  bounds.peak_slew_um_per_s = peak.velocity_um_per_s;
  bounds.peak_acceleration_um_per_s2 = peak.acceleration_um_per_s2;
  return bounds;
}

MotionBounds motion_bounds_of(const Sine& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  const double omega = 2.0 * std::numbers::pi * s.frequency_Hz;
  bounds.peak_slew_um_per_s = 0.5 * omega * (bounds.highest_um - bounds.lowest_um);
  bounds.peak_acceleration_um_per_s2 = omega * bounds.peak_slew_um_per_s;
  return bounds;
}

MotionBounds motion_bounds_of(const Chirp& s) {
  MotionBounds bounds = between(s.low_um, s.high_um);
  add_faded(bounds, 0.5 * (bounds.highest_um - bounds.lowest_um), std::max(s.from_Hz, s.to_Hz),
            (s.to_Hz - s.from_Hz) / s.duration_s, s.fade_s);
  return bounds;
}

MotionBounds bound_of(const MultiSine& s) {
  MotionBounds bounds = between(s.centre_um, s.centre_um);
  for (std::size_t k = 0; k < s.amplitudes_um.size(); ++k) {
    const double amplitude_um = std::abs(s.amplitudes_um[k]);
    bounds.lowest_um -= amplitude_um;
    bounds.highest_um += amplitude_um;
    add_faded(bounds, amplitude_um, s.frequencies_Hz[k], 0.0, s.fade_s);
  }
  return bounds;
}

MotionBounds motion_bounds_of(const MultiSine& s) {
  constexpr double points_per_period = 64.0;
  constexpr double most_points = 1e6;
  const double length_s = duration_s(s);
  const double shortest_s = std::min(1.0 / std::ranges::max(s.frequencies_Hz), s.fade_s);
  const double points = std::ceil(points_per_period * length_s / shortest_s);
  if (points > most_points) return bound_of(s);
  MotionBounds bounds = between(s.centre_um, s.centre_um);
  for (int i = 0; i <= static_cast<int>(points); ++i) {
    const Motion at = motion(s, length_s * i / points);
    bounds.lowest_um = std::min(bounds.lowest_um, at.value_um);
    bounds.highest_um = std::max(bounds.highest_um, at.value_um);
    bounds.peak_slew_um_per_s = std::max(bounds.peak_slew_um_per_s, std::abs(at.velocity_um_per_s));
    bounds.peak_acceleration_um_per_s2 =
        std::max(bounds.peak_acceleration_um_per_s2, std::abs(at.acceleration_um_per_s2));
  }
  return bounds;
}

MotionBounds motion_bounds_of(const Staircase& s) {
  const auto [lowest, highest] = std::ranges::minmax(s.levels_um);
  MotionBounds bounds = between(lowest, highest);
  if (s.rise_s == 0.0) return bounds;
  for (std::size_t i = 1; i < s.levels_um.size(); ++i) {
    const double height_um = std::abs(s.levels_um[i] - s.levels_um[i - 1]);
    bounds.peak_slew_um_per_s =
        std::max(bounds.peak_slew_um_per_s, smooth_step_peak_slope * height_um / s.rise_s);
    bounds.peak_acceleration_um_per_s2 = std::max(
        bounds.peak_acceleration_um_per_s2, smooth_step_peak_curvature * height_um / (s.rise_s * s.rise_s));
  }
  return bounds;
}

MotionBounds motion_bounds_of(const Table& s) { return s.curve.bounds(); }

}  // namespace

Sawtooth rounded(const Triangle& s) {
  const double period_s = 1.0 / s.frequency_Hz;
  return {s.low_um, s.high_um, period_s, 0.5,
          Turnaround(0.005 * s.turnaround_percent * period_s, s.mode_period_s)};
}

std::string to_string(const Shape& shape) { return std::string(shape_kinds[shape.index()]); }

Shape shape_of_kind(std::string_view kind) {
  return default_shape(static_cast<std::size_t>(std::ranges::find(shape_kinds, kind) - shape_kinds.begin()));
}

Shape prepared(Shape shape) {
  if (auto* multi_sine = std::get_if<MultiSine>(&shape)) prepare(*multi_sine);
  if (auto* raster = std::get_if<Raster>(&shape)) prepare(*raster);
  return shape;
}

double duration_s(const Shape& shape) {
  return std::visit([](const auto& s) { return duration_of(s); }, shape);
}

double value_um(const Shape& shape, double t_s) {
  return std::visit([&](const auto& s) { return motion_of(s, t_s).value_um; }, shape);
}

bool has_turnarounds(const Shape& shape) {
  if (const auto* triangle = std::get_if<Triangle>(&shape)) return triangle->turnaround_percent > 0.0;
  const auto* raster = std::get_if<Raster>(&shape);
  return raster != nullptr && raster->turnaround_percent > 0.0;
}

double ideal_um(const Shape& shape, double t_s) {
  return std::visit([&](const auto& s) { return ideal_of(s, t_s); }, shape);
}

Motion motion(const Shape& shape, double t_s) {
  return std::visit([&](const auto& s) { return motion_of(s, t_s); }, shape);
}

bool rests(const Shape& shape, double t_s) {
  return std::visit([&](const auto& s) { return rests_in(s, t_s); }, shape);
}

std::optional<ScanPlace> place_in_scan(const Shape& shape, double t_s) {
  const auto* raster = std::get_if<Raster>(&shape);
  return raster == nullptr ? std::nullopt : place_of(*raster, t_s);
}

MotionBounds motion_bounds(const Shape& shape) {
  return std::visit([](const auto& s) { return motion_bounds_of(s); }, shape);
}

}  // namespace hystcan::controller
