// The raster of a scan: the fast axis draws lines, and the slow axis moves from line to line. The two axes
// have the same Raster, except for role, low and high. Therefore both have the same duration and stay in
// phase.
//
//   T                           duration of a line, 1 / line_rate_Hz
//   frame                       `lines` lines, then a return of the slow axis of `return_lines` times T
//
//   fast axis, both directions  rises in line 0, falls in line 1, and so on
//   fast axis, one direction    in every line, rises and then falls back: a flyback of flyback_percent of T
//   slow axis, step             rests at the level of line k, k = 0 .. lines - 1, during this line. The level
//                               is low + (high - low) k / (lines - 1). The slow axis moves to the next level
//                               along the smooth step, during the turnaround or flyback of the fast axis
//   slow axis, ramp             rises evenly during the lines of a frame and falls during the return
//
// The fast axis continues its lines during the return. A turnaround (motion.h) rounds each corner of the fast
// axis and of a ramp. The turnarounds of the fast axis take turnaround_percent of T. Without turnaround and
// flyback, a slow axis with steps jumps from level to level. Every frame ends at the position where the frame
// began.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "controller/reference/motion.h"

namespace hystcan::controller {

enum class ScanRole : std::uint8_t { fast, slow };
constexpr auto words(ScanRole) { return std::to_array<std::string_view>({"fast", "slow"}); }

enum class SlowMotion : std::uint8_t { step, ramp };
constexpr auto words(SlowMotion) { return std::to_array<std::string_view>({"step", "ramp"}); }

struct Raster {
  ScanRole role = ScanRole::fast;
  double low_um = 0.0;
  double high_um = 1.0;
  double line_rate_Hz = 1.0;
  unsigned lines = 2;  ///< number of lines in a frame, two or more
  unsigned return_lines = 2;
  unsigned frames = 1;
  unsigned pixels = 0;  ///< number of pixels in a line; 0: pixels are not counted
  bool both_directions = true;
  /// Duration of the flyback, in percent of a line; ignored if both_directions.
  double flyback_percent = 50.0;
  SlowMotion slow = SlowMotion::step;
  double turnaround_percent = 0.0;
  double mode_period_s = 0.0;  ///< period of the stage's vibration mode, for the turnarounds; 0: no mode
  /// `wave`: periodic motion of the fast axis, or of a slow axis with a ramp. `way_up_s`: time that the fast
  /// axis needs from the lowest to the highest point of a line. prepare() sets both.
  Sawtooth wave{};
  double way_up_s = 0.0;

  double line_s() const { return 1.0 / line_rate_Hz; }
  double frame_s() const { return (lines + return_lines) * line_s(); }
  double duration_s() const { return frames * frame_s(); }
};

/// The present frame, line and pixel of a scan. Each is counted from 0.
struct ScanPlace {
  std::uint32_t frame = 0;
  std::uint32_t line = 0;
  /// Pixel, counted from the low_um end of the line. It is no_pixel during a turnaround or a flyback, or if
  /// pixels are not counted.
  std::int32_t pixel = no_pixel;

  static constexpr std::int32_t no_pixel = -1;
};

/// Computes from the other members `wave`, the periodic motion of the axis, and `way_up_s`, the time from the
/// lowest to the highest point of a line. Throws std::invalid_argument if the members contradict each other.
void prepare(Raster& raster);
Motion motion_of(const Raster& raster, double t_s);
/// Returns the position that motion_of() would have with sharp corners instead of rounded ones (turnarounds).
double ideal_of(const Raster& raster, double t_s);
bool rests_in(const Raster& raster, double t_s);
/// Returns the maximum velocity and acceleration of a raster. Corners and jumps do not count.
Motion peak_motion(const Raster& raster);
/// Returns the present frame, line and pixel, which are the same for both axes. Returns `nullopt` before and
/// after the scan and during a return.
std::optional<ScanPlace> place_of(const Raster& raster, double t_s);

}  // namespace hystcan::controller
