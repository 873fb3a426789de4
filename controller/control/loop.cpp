#include "controller/control/loop.h"

#include <utility>

namespace hystcan::controller {

ClosedLoop::ClosedLoop(const AxisConfig& config)
    : law_(config.law), trajectory_(reference_of(config)), following_error_(config.following_error) {
  if (config.learning) learning_.emplace(*config.learning);
  apply(config);
}

void ClosedLoop::apply(const AxisConfig& config) {
  delays_ = config.delays;
  if (!config.plant_inverse || !feeds_forward(config.law.structure))
    plant_inverse_.reset();
  else if (plant_inverse_)
    plant_inverse_->retune(*config.plant_inverse);
  else
    plant_inverse_.emplace(*config.plant_inverse);
  notch_ = config.law.notch;
  judged_by_ = config.in_position;
  moments_for_s_ = 0.0;
}

void ClosedLoop::retune(const AxisConfig& config, std::optional<Trajectory>& reference,
                        std::optional<Learning>& learning, double t_s) {
  const auto [since_s, for_s] = used(t_s);
  prepared_.reset();
  apply(config);
  if (learning && learning_) learning->continue_from(*learning_);
  if (learning)
    std::swap(learning, learning_);
  else if (learning_)
    learning_->retire();
  law_.retune(config.law);
  following_error_ = FollowingError(config.following_error);
  trajectory_.keep(transition_limits_of(config));
  if (!reference) return;
  reference->continue_from(trajectory_, since_s, for_s);
  std::swap(*reference, trajectory_);
}

void ClosedLoop::go_to(double t_s, double goal_um) {
  const auto [since_s, for_s] = used(t_s);
  trajectory_.go_to(since_s, goal_um, for_s);
  in_position_ = {};
}

void ClosedLoop::resume(double t_s) {
  const auto [since_s, for_s] = used(t_s);
  trajectory_.resume(since_s, for_s);
  in_position_ = {};
}

// At the upper threshold, all memory of the actuator is wiped out. From there on, the model's memory agrees
// with the actuator's memory. If drive_max reaches the upper threshold, the lower threshold is not visited in
// two cases: if drive_min is above the lower threshold, or for a butterfly actuator (a model with an output
// map), which works only on the side of its valley where the upper threshold is.
std::vector<double> ClosedLoop::ramp_in(const Gate::Config& gate) const {
  const model::HysteresisParameters& model = law_.model().parameters();
  const model::Interval& thresholds = model.input_range();
  const bool is_enough = gate.drive_min > thresholds.lo || model.output_map;
  if (gate.drive_max >= thresholds.hi && is_enough) return {thresholds.hi};
  return {thresholds.hi, thresholds.lo};
}

/// At the start, the measured position contains the displacement by the other axes (coupling), and the
/// integral compensates it. Therefore the feed-forward compensates only later changes of the coupling.
void ClosedLoop::begin(double t_s, double position_um, double coupled_um, bool goes_on) {
  coupled_at_first_um_ = coupled_um;
  if (plant_inverse_) plant_inverse_->restart(t_s);
  following_error_.restart();
  in_position_ = {};
  trajectory_.join(t_s, law_.restart(position_um), goes_on);
  prepared_.reset();
}

void ClosedLoop::prepare(double t_s, double cycle_s) {
  if (prepared_ && prepared_->t_s == t_s) return;
  const Trajectory::Point point = trajectory_.at(t_s - delays_.sensor_s());
  prepared_ = {.t_s = t_s,
               .point = point,
               .expected_um = expected_um(t_s, cycle_s, point),
               .previewed_um = previewed_um(t_s, cycle_s)};
}

std::optional<double> ClosedLoop::propose(const AxisInput& input, double t_s, bool waited,
                                          AxisReport& report) {
  prepare(t_s, input.cycle_s);
  const Prepared prepared = *std::exchange(prepared_, std::nullopt);
  const Trajectory::Point& point = report.point = prepared.point;
  report.reference_um = point.value_um;
  if (input.position_um && !following_error_.step(point.value_um, *input.position_um, input.dt_s))
    return std::nullopt;
  if (judged_by_)
    report.arrival = InPosition::step(*judged_by_, in_position_, point, input.position_um, input.dt_s);
  Learning::Correction learnt;
  if (learning_) {
    learnt = learn(input, t_s, prepared.expected_um, waited, point);
    report.learning = learning_->report();
  }
  report.previewed_um = prepared.previewed_um + learnt.ahead_um - input.coupled_um + coupled_at_first_um_;
  const ControlLaw::Demand demand = law_.propose({.reference_um = prepared.expected_um + learnt.now_um,
                                                  .previewed_um = report.previewed_um,
                                                  .position_um = input.position_um,
                                                  .dt_s = input.dt_s,
                                                  .cycle_s = input.cycle_s});
  report.demand_um = demand.position_um;
  report.limits = demand.limits;
  report.integral_um = law_.integral_um();
  report.memory_depth = static_cast<std::uint32_t>(law_.memory().depth());
  return demand.drive;
}

void ClosedLoop::commit(double applied_drive, std::uint8_t limits) {
  is_limited_ = limits != limit::none;
  law_.commit(applied_drive);
}

Learning::Correction ClosedLoop::learn(const AxisInput& input, double t_s, double expected_um, bool waited,
                                       const Trajectory::Point& point) {
  std::optional<double> error_um;
  if (input.position_um) error_um = expected_um - *input.position_um;
  learning_->learn(point, error_um, !is_limited_ && !waited);
  const double ahead_s = static_cast<double>(learning_->ahead_cycles()) * input.cycle_s;
  Trajectory::Point ahead = point;
  ahead.shape_time_s += ahead_s;
  if (!learning_->covers(ahead)) ahead = trajectory_.at(t_s - delays_.sensor_s() + ahead_s);
  return learning_->correct(point, ahead, input.dt_s);
}

double ClosedLoop::preview_s(double cycle_s) {
  if (cycle_s != moments_for_s_) {
    moments_ = chain_moments(delays_, notch_, cycle_s);
    moments_for_s_ = cycle_s;
  }
  return moments_.mean_s;
}

ClosedLoop::Used ClosedLoop::used(double t_s) const {
  if (prepared_) t_s = prepared_->t_s;
  const double sample_s = delays_.sensor_s();
  const double cycles = plant_inverse_ ? feed_forward_reach : delays_.second_order ? 1.0 : 0.0;
  const double ahead_s = moments_for_s_ == 0.0 ? 0.0 : moments_.mean_s + cycles * moments_for_s_;
  return {.since_s = t_s - sample_s, .for_s = sample_s + ahead_s};
}

double ClosedLoop::expected_um(double t_s, double cycle_s, const Trajectory::Point& point) {
  if (!plant_inverse_) return point.value_um;
  return plant_inverse_->expected(t_s + preview_s(cycle_s), cycle_s,
                                  [&](double at_s) { return trajectory_.value_um(at_s); });
}

double ClosedLoop::previewed_um(double t_s, double cycle_s) {
  const double mean_s = preview_s(cycle_s);
  const auto reference = [&](double at_s) { return trajectory_.value_um(at_s); };
  if (plant_inverse_) return plant_inverse_->feed_forward(t_s + mean_s, cycle_s, reference);
  if (!delays_.second_order) return reference(t_s + mean_s);
  return second_order_preview(moments_, cycle_s, [&](double ahead_s) { return reference(t_s + ahead_s); });
}

}  // namespace hystcan::controller
