// The way from one reference to the next, without a jump of the drive.
//
//   t_0 .. t_0 + h    lead: the old reference, unchanged
//   .. + T_b          braking to a stand, from the motion at t_0 + h (Transition::to_stand)
//   .. + T            onward: from the stand to the goal (Transition)
//
// h is the preview. The feed-forward of a chain of delay mu uses r(t + mu): at t_0 the drive already follows
// the old reference up to t_0 + mu. A new reference that began at t_0 would make the feed-forward jump by
//
//   |r_new(t_0 + mu) - r_old(t_0 + mu)|:   up to mu |v| after a stop, up to 2 mu |v| before a corner
//
// whatever the limits of slew and acceleration. From t_0 + h on, the drive moves as smoothly as the reference.
//
// The lead is stored as points with straight lines between them: it rounds a corner over h / 32.
#pragma once

#include <array>
#include <cstddef>

#include "controller/reference/shape.h"
#include "controller/reference/transition.h"

namespace hystcan::controller {

class Handover {
 public:
  static constexpr std::size_t lead_intervals = 32;
  using Lead = std::array<double, lead_intervals + 1>;

  /// Has no duration and ends at 0.
  Handover() = default;
  /// Has no lead and no braking.
  explicit Handover(const Transition& onward) : onward_(onward) {}
  /// `lead`: points in um at equal intervals of lead_s; not used where lead_s is 0.
  Handover(const Lead& lead, double lead_s, const Transition& braking, const Transition& onward)
      : lead_(lead), lead_s_(lead_s), braking_(braking), onward_(onward) {}

  double duration_s() const { return lead_s_ + braking_.duration_s() + onward_.duration_s(); }
  /// `t_s` counts from the beginning; after the end the value is the goal.
  double value_um(double t_s) const;
  Motion at(double t_s) const;

 private:
  Lead lead_{};
  double lead_s_ = 0.0;
  Transition braking_;
  Transition onward_;
};

}  // namespace hystcan::controller
