// The reference r(t): a sequence of segments, joined smoothly, known ahead of time so that delays can be
// previewed.
#pragma once

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

namespace hystcan::controller {

struct Hold {
  double level_um = 0.0;
  double duration_s = 1.0;
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

/// Level after level: `rise_s` to get there (0: a step), then `dwell_s`.
struct Staircase {
  std::vector<double> levels_um;
  double rise_s = 0.0;
  double dwell_s = 0.1;
};

using Shape = std::variant<Hold, Ramp, Triangle, Sine, Staircase>;

std::string to_string(const Shape& shape);
double duration_s(const Shape& shape);
/// Value at `t` seconds after the shape's beginning; held at both ends.
double value_um(const Shape& shape, double t_s);

/// The smooth step 10 s^3 - 15 s^4 + 6 s^5 (least jerk): 0 at s <= 0, 1 at s >= 1.
double smooth_step(double s);

struct Segment {
  Shape shape;
  double transition_s = 0.1;  ///< smooth way from wherever the reference is to the shape's first value
};

/// r(t), t from 0. Starts at `start_um`; after the last segment it holds, or starts over where `repeat`.
class Trajectory {
 public:
  Trajectory(std::vector<Segment> segments, bool repeat);

  void start_from(double start_um);

  struct Point {
    double value_um = 0.0;
    std::size_t segment = 0;
    bool in_transition = false;
    bool finished = false;
    double shape_time_s = 0.0;  ///< since the shape's beginning
  };
  Point at(double t_s) const;

  double length_s() const { return length_s_; }  ///< of one pass
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  std::vector<Segment> segments_;
  bool repeat_;
  double length_s_ = 0.0;
  double start_um_ = 0.0;
  double end_um_ = 0.0;
};

}  // namespace hystcan::controller
