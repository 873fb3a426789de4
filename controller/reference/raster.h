// The raster of a scan: lines along a fast axis, one after another along a slow axis. Both axes have a Raster
// that differs only in role, low and high; the two therefore have the same duration and stay in phase.
//
//   T = 1 / line_rate: the time of a line         a frame: `lines` lines, then `return_lines` times T back
//
//   fast, both directions    up in line 0, down in line 1, and so on
//   fast, one direction      up, then down within flyback_percent of T, in every line
//   slow, step               rests at the level of the line, k of 0 .. lines - 1:
//                            low + (high - low) k / (lines - 1); moves to the next one along the smooth step,
//                            during the turnaround or the flyback
//   slow, ramp               rises evenly during the lines of a frame and falls during the return
//
// The fast axis continues during the return. Its turnarounds, and those of a ramp, are defined in motion.h;
// turnaround_percent and flyback_percent are shares of T. Without turnaround and flyback, the slow axis steps
// immediately. Every frame ends at its beginning, at rest except for the corners of a ramp without a
// turnaround.
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
  unsigned lines = 2;  ///< lines of a frame, two or more
  unsigned return_lines = 2;
  unsigned frames = 1;
  unsigned pixels = 0;  ///< pixels of a line; 0: not counted
  bool both_directions = true;
  double flyback_percent = 50.0;  ///< ignored if both_directions
  SlowMotion slow = SlowMotion::step;
  double turnaround_percent = 0.0;
  double mode_period_s = 0.0;  ///< period of the stage's mode, for Turnaround
  /// `wave`: motion of the fast axis, or of a ramp. `way_up_s`: time from the lowest to the highest point of
  /// a line. Both are set by prepared().
  Sawtooth wave{};
  double way_up_s = 0.0;

  double line_s() const { return 1.0 / line_rate_Hz; }
  double frame_s() const { return (lines + return_lines) * line_s(); }
  double duration_s() const { return frames * frame_s(); }
};

/// The present place of a scan, counted from 0.
struct ScanPlace {
  std::uint32_t frame = 0;
  std::uint32_t line = 0;
  /// Counted from the low_um end of the line; no_pixel in a turnaround, in the flyback, and if pixels are not
  /// counted.
  std::int32_t pixel = no_pixel;

  static constexpr std::int32_t no_pixel = -1;
};

/// Sets `wave` and `way_up_s`. Throws std::invalid_argument if the parameters contradict each other.
void prepare(Raster& raster);
Motion motion_of(const Raster& raster, double t_s);
/// Returns the position that motion_of() would have with sharp corners instead of turnarounds.
double ideal_of(const Raster& raster, double t_s);
bool rests_in(const Raster& raster, double t_s);
/// Returns the maximum velocity and acceleration, without corners and jumps.
Motion peak_motion(const Raster& raster);
/// Returns the place of the scan, the same for both axes. `nullopt` outside the lines: before and after the
/// scan, and during a return.
std::optional<ScanPlace> place_of(const Raster& raster, double t_s);

}  // namespace hystcan::controller
