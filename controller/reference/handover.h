// From a reference that is left to the one that follows, without a jump of the drive.
//
//   t_0 .. t_0 + h            the reference that is left, as it was: lead
//   .. + T_b                  braking to a stand, from the motion that it has at t_0 + h
//   (Transition::to_stand)
//   .. + T                    from there to the goal (Transition)
//
// At t_0 the drive has been given what the reference is up to t_0 + h, h the preview: a chain of delay mu is
// fed r(t + mu). A reference that departed at t_0 already would be looked up at t_0 + mu all at once, and
// the feed-forward would jump
//
//   by |r_new(t_0 + mu) - r_left(t_0 + mu)|,   up to mu |v| after a stop, 2 mu |v| before a corner
//
// whatever the limits of slew and acceleration. From t_0 + h on it goes on as smoothly as the reference does.
//
// The lead is kept as points, linear between them: a corner of it is rounded over h / 32.
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

  /// Of no duration, to 0.
  Handover() = default;
  /// The transition alone.
  explicit Handover(const Transition& onward) : onward_(onward) {}
  /// `lead`: in um, at equal distances over lead_s; unused where that is 0.
  Handover(const Lead& lead, double lead_s, const Transition& braking, const Transition& onward)
      : lead_(lead), lead_s_(lead_s), braking_(braking), onward_(onward) {}

  double duration_s() const { return lead_s_ + braking_.duration_s() + onward_.duration_s(); }
  /// From its beginning on; the goal after its end.
  double value_um(double t_s) const;
  Motion at(double t_s) const;

 private:
  Lead lead_{};
  double lead_s_ = 0.0;
  Transition braking_;
  Transition onward_;
};

}  // namespace hystcan::controller
