#include "controller/loop.h"

#include <cmath>
#include <limits>

namespace hystcan::controller {

ClosedLoop::ClosedLoop(const Config& config)
    : config_(config), law_(config.law), trajectory_(config.setpoint, config.repeat) {}

std::vector<double> ClosedLoop::ramp_in() const {
  const model::Interval& thresholds = law_.inverted().input_range();
  return {thresholds.hi, thresholds.lo};
}

void ClosedLoop::begin(double position_um) {
  badly_following_ = 0;
  trajectory_.start_from(law_.restart_at_lower_threshold(position_um));
}

Proposal ClosedLoop::propose(const LoopInput& input) {
  Proposal proposal{.point = trajectory_.at(input.t_s)};
  proposal.reference_um = proposal.point.value_um;
  proposal.follows = !input.position_um || follows(proposal.reference_um - *input.position_um);
  if (!proposal.follows) return proposal;
  const ControlLaw::Demand demand = law_.propose({.reference_um = proposal.reference_um,
                                                  .previewed_um = previewed_um(input),
                                                  .position_um = input.position_um,
                                                  .dt_s = input.dt_s,
                                                  .cycle_s = input.cycle_s,
                                                  .steady = !proposal.point.in_transition});
  proposal.drive = demand.drive;
  proposal.demand_um = demand.position_um;
  proposal.limits = demand.limits;
  proposal.correction = law_.correction();
  return proposal;
}

double ClosedLoop::previewed_um(const LoopInput& input) {
  if (input.cycle_s != moments_for_s_) {
    moments_ = chain_moments(config_.delays, config_.law.notch, input.cycle_s);
    moments_for_s_ = input.cycle_s;
  }
  const auto reference = [&](double ahead_s) { return trajectory_.at(input.t_s + ahead_s).value_um; };
  if (!config_.delays.second_order) return reference(moments_.mean_s);
  return second_order_preview(moments_, input.cycle_s, reference);
}

bool ClosedLoop::follows(double error_um) {
  badly_following_ = std::abs(error_um) > config_.following_error_um ? badly_following_ + 1 : 0;
  return badly_following_ < config_.following_error_cycles;
}

OpenLoop::OpenLoop(const Excitation::Config& config, const Gate::Config& gate) : excitation_(config) {
  refuse_beyond(gate, excitation_);
}

Proposal OpenLoop::propose(const LoopInput& input) const {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  Proposal proposal;
  proposal.drive = excitation_.at(input.t_s);
  proposal.reference_um = proposal.demand_um = none;
  proposal.point.shape_time_s = input.t_s;
  proposal.point.finished = input.t_s >= excitation_.length_s();
  return proposal;
}

}  // namespace hystcan::controller
