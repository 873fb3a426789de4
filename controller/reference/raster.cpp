#include "controller/reference/raster.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace hystcan::controller {
namespace {

double turnaround_s(const Raster& raster) {
  const double all_s = 0.01 * raster.turnaround_percent * raster.line_s();
  return raster.both_directions ? all_s : 0.5 * all_s;
}

Sawtooth lines_of(const Raster& raster) {
  const Turnaround turnaround(turnaround_s(raster), raster.mode_period_s);
  const double period_s = (raster.both_directions ? 2.0 : 1.0) * raster.line_s();
  const double rise_share = raster.both_directions ? 0.5 : 1.0 - 0.01 * raster.flyback_percent;
  return {raster.low_um, raster.high_um, period_s, rise_share, turnaround};
}

Sawtooth ramp_of(const Raster& raster) {
  const double rise_share = raster.lines / static_cast<double>(raster.lines + raster.return_lines);
  return {raster.low_um, raster.high_um, raster.frame_s(), rise_share,
          Turnaround(turnaround_s(raster), raster.mode_period_s)};
}

bool is_waving(const Raster& raster) {
  return raster.role == ScanRole::fast || raster.slow == SlowMotion::ramp;
}

/// Tolerance of a line number. A cycle at the beginning of a line must belong to this line, although its time
/// is rounded.
constexpr double rounding = 1e-6;

/// Returns the number of lines from the beginning of the scan until `t_s`, including the fraction of the
/// present line, plus the tolerance for rounding.
double lines_until(const Raster& raster, double t_s) { return t_s * raster.line_rate_Hz + rounding; }

/// One move of a slow axis with steps (SlowMotion::step): from the level of a line to the level of the next
/// line. The move after the last line of a frame returns to the level of the first line.
struct Move {
  double from_um = 0.0;
  double to_um = 0.0;
  double begins_s = 0.0;  ///< time since the beginning of the frame
  double lasts_s = 0.0;
};

Move move_after(const Raster& raster, double line) {
  const double last = raster.lines - 1.0;
  const double line_s = raster.line_s();
  const double ends_s = (line + 1.0) * line_s;
  const auto level_um = [&](double k) { return raster.low_um + (raster.high_um - raster.low_um) * k / last; };
  Move move{.from_um = level_um(line), .to_um = raster.low_um};
  if (raster.both_directions) {
    const double half_s = line < last ? 0.5 * turnaround_s(raster) : 0.0;
    move.begins_s = ends_s - half_s;
    move.lasts_s = 2.0 * half_s;
  } else {
    move.begins_s = line * line_s + raster.way_up_s;
    move.lasts_s = line_s - raster.way_up_s;
  }
  if (line < last)
    move.to_um = level_um(line + 1.0);
  else
    move.lasts_s = raster.frame_s() - move.begins_s;
  return move;
}

/// Returns the last move of the slow axis that has begun before `t_s`, and the time since the beginning of
/// this move. Before the first move of a frame, returns the first move and a negative time.
std::pair<Move, double> in_frame(const Raster& raster, double t_s) {
  const double frames = std::floor(lines_until(raster, t_s) / (raster.lines + raster.return_lines));
  const double since_s = t_s - std::clamp(frames, 0.0, raster.frames - 1.0) * raster.frame_s();
  const double line =
      std::clamp(std::floor(lines_until(raster, since_s)), 0.0, static_cast<double>(raster.lines - 1));
  Move move = move_after(raster, line);
  if (since_s < move.begins_s && line > 0.0) move = move_after(raster, line - 1.0);
  return {move, since_s - move.begins_s};
}

Motion steps_of(const Raster& raster, double t_s) {
  const auto [move, since_s] = in_frame(raster, t_s);
  if (move.lasts_s == 0.0)
    return {.value_um = since_s * raster.line_rate_Hz < -rounding ? move.from_um : move.to_um};
  return smooth_rise(move.from_um, move.to_um, since_s, move.lasts_s);
}

}  // namespace

void prepare(Raster& raster) {
  const unsigned period_lines = raster.lines + raster.return_lines;
  std::ostringstream refusal;
  if (raster.both_directions && period_lines % 2 != 0)
    refusal << "lines + return_lines is " << period_lines
            << ", expected an even number: otherwise, with both_directions, every second frame starts at the "
               "other end of the line";
  const double shorter = std::min(raster.flyback_percent, 100.0 - raster.flyback_percent);
  if (!raster.both_directions && 0.5 * raster.turnaround_percent > shorter)
    refusal << "turnaround_percent is " << raster.turnaround_percent << ", expected at most " << 2.0 * shorter
            << ": half of the turnaround must fit into the trace and into the flyback of "
            << raster.flyback_percent << " %";
  if (!refusal.view().empty()) throw std::invalid_argument(refusal.str());
  const Sawtooth lines = lines_of(raster);
  raster.way_up_s = lines.way_up_s();
  raster.wave = raster.role == ScanRole::fast ? lines : ramp_of(raster);
}

Motion motion_of(const Raster& raster, double t_s) {
  if (!is_waving(raster)) return steps_of(raster, std::max(t_s, 0.0));
  if (t_s >= 0.0 && t_s < raster.duration_s()) return raster.wave.at(t_s);
  return {.value_um = raster.wave.at(0.0).value_um};
}

double ideal_of(const Raster& raster, double t_s) {
  const bool within = t_s >= 0.0 && t_s < raster.duration_s();
  return is_waving(raster) && within ? raster.wave.ideal_um(t_s) : motion_of(raster, t_s).value_um;
}

bool rests_in(const Raster& raster, double t_s) {
  if (t_s >= raster.duration_s()) return true;
  if (is_waving(raster)) return false;
  const auto [move, since_s] = in_frame(raster, t_s);
  return since_s < 0.0 || since_s >= move.lasts_s;
}

Motion peak_motion(const Raster& raster) {
  if (is_waving(raster))
    return {.velocity_um_per_s = raster.wave.peak_slew_um_per_s(),
            .acceleration_um_per_s2 = raster.wave.peak_acceleration_um_per_s2()};
  Motion peak;
  for (const double line : {0.0, raster.lines - 1.0}) {
    const Move move = move_after(raster, line);
    if (move.lasts_s == 0.0) continue;
    const double slope_um_per_s = std::abs(move.to_um - move.from_um) / move.lasts_s;
    peak.velocity_um_per_s = std::max(peak.velocity_um_per_s, smooth_step_peak_slope * slope_um_per_s);
    peak.acceleration_um_per_s2 =
        std::max(peak.acceleration_um_per_s2, smooth_step_peak_curvature * slope_um_per_s / move.lasts_s);
  }
  return peak;
}

std::optional<ScanPlace> place_of(const Raster& raster, double t_s) {
  const double lines = std::floor(lines_until(raster, t_s));
  const double period_lines = raster.lines + raster.return_lines;
  const double frame = std::floor(lines / period_lines);
  const double line = lines - frame * period_lines;
  if (frame < 0.0 || frame >= raster.frames || line >= raster.lines) return std::nullopt;
  ScanPlace place{.frame = static_cast<std::uint32_t>(frame), .line = static_cast<std::uint32_t>(line)};
  if (raster.pixels == 0) return place;
  // Pixels cover only the straight part of a line. This part is in the middle of the way from the lowest to
  // the highest point.
  const double line_s = raster.line_s();
  const double rise_s = raster.both_directions ? line_s : (1.0 - 0.01 * raster.flyback_percent) * line_s;
  const double straight_s = rise_s - turnaround_s(raster);
  const double share = (t_s - lines * line_s - 0.5 * (raster.way_up_s - straight_s)) / straight_s;
  const double pixel = std::floor(share * raster.pixels + rounding);
  if (!(pixel >= 0.0 && pixel < raster.pixels)) return place;
  const bool comes_back = raster.both_directions && place.line % 2 != 0;
  place.pixel = static_cast<std::int32_t>(comes_back ? raster.pixels - 1.0 - pixel : pixel);
  return place;
}

}  // namespace hystcan::controller
