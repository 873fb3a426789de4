#include "controller/control/learning.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"

namespace hystcan::controller {
namespace {

/// Time in s at both ends of a segment in which the correction fades in or out.
constexpr double ends_s = 0.01;

/// Time constant in s with which a correction fades out when it ends.
constexpr double fade_s = 0.02;

/// An attempt to learn has failed if, in `grown_periods` consecutive periods, the RMS error is above
/// `grown_factor` times the RMS error without learning.
constexpr double grown_factor = 1.3;
constexpr unsigned grown_periods = 3;
/// Number of periods for which a segment rests after a failed attempt to learn. A resting segment is not
/// corrected. The last of these periods gives a new value for the error without learning.
constexpr unsigned rest_periods = 3;
constexpr unsigned most_attempts = 3;
/// An error above this factor times the largest error without learning is a glitch, which is not learnt. For
/// the judgement, a glitch is limited to this value, so that many glitches still count as a grown error.
constexpr double glitch_factor = 4.0;

/// Returns the factor that multiplies the correction. It falls smoothly to 0 at both ends of the segment,
/// because the correction of a neighbouring segment is 0 there.
double share_of(const Learning::Plan& plan, double shape_time_s) {
  return smooth_step(shape_time_s / ends_s) * smooth_step((plan.duration_s - shape_time_s) / ends_s);
}

}  // namespace

Learning::Learning(const Config& config) : config_(config) {
  segments_.resize(config_.plans.size());
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const Plan& plan = config_.plans[i];
    if (plan.taps.empty()) continue;
    if (!(plan.cycle_s > 0.0)) refuse("cycle_s = ", plan.cycle_s, ", expected a positive number");
    if (plan.taps.size() % 2 == 0 || plan.taps.size() > plan.phases)
      refuse("a learning filter of ", plan.taps.size(), " taps for ", plan.phases,
             " phases (the control cycles that are learnt together), expected an odd number of taps, at most "
             "the number of phases");
    segments_[i].correction_um.assign(plan.phases, 0.0);
    segments_[i].cycles_per_s = 1.0 / plan.cycle_s;
    segments_[i].phases_per_s =
        plan.period_s > 0.0 ? static_cast<double>(plan.phases) / plan.period_s : 1.0 / plan.cycle_s;
    segments_[i].taps.assign(plan.taps.begin(), plan.taps.end());
    segments_[i].errors_um.assign(2 * plan.taps.size(), 0.0F);
  }
}

const Learning::Plan* Learning::plan_at(const Trajectory::Point& point) const {
  if (point.in_transition || point.finished || point.live || point.segment >= config_.plans.size())
    return nullptr;
  const Plan& plan = config_.plans[point.segment];
  return plan.taps.empty() ? nullptr : &plan;
}

bool Learning::covers(const Trajectory::Point& point) const {
  const Plan* plan = plan_at(point);
  return plan != nullptr && point.shape_time_s < plan->duration_s;
}

std::optional<double> Learning::target_um(const Trajectory::Point& point) const {
  const Plan* plan = plan_at(point);
  if (plan == nullptr || retired_) return std::nullopt;
  const Segment& segment = segments_[point.segment];
  if (segment.judgement.is_idle()) return std::nullopt;
  const Phase phase = segment.phase_at(point.shape_time_s);
  const double here_um = segment.correction_um[phase.index], next_um = segment.correction_um[phase.next];
  return share_of(*plan, point.shape_time_s) * (here_um + phase.share * (next_um - here_um));
}

Learning::Phase Learning::Segment::phase_at(double shape_time_s) const {
  const std::size_t count = correction_um.size();
  const double phases = std::max(shape_time_s, 0.0) * phases_per_s;
  const double whole = std::floor(phases / static_cast<double>(count)) * static_cast<double>(count);
  const double in_period = std::max(phases - whole, 0.0);
  const auto index = static_cast<std::size_t>(in_period);
  const double share = in_period - static_cast<double>(index);
  return {index, after(index), share};
}

double Learning::Output::step(const std::optional<double>& target_um, double decay) {
  if (follows != target_um.has_value()) fading_um = last_um - target_um.value_or(0.0);
  follows = target_um.has_value();
  fading_um *= decay;
  last_um = target_um.value_or(0.0) + fading_um;
  return last_um;
}

Learning::Correction Learning::correct(const Trajectory::Point& now, const Trajectory::Point& ahead,
                                       double dt_s) {
  const double decay = dt_s < fade_s ? 1.0 - dt_s / fade_s : 0.0;
  report_.correction_um = now_.step(target_um(now), decay);
  return {.now_um = report_.correction_um, .ahead_um = ahead_.step(target_um(ahead), decay)};
}

void Learning::learn(const Trajectory::Point& point, std::optional<double> error_um, bool undisturbed) {
  const Plan* plan = plan_at(point);
  if (plan == nullptr || !error_um || !undisturbed || retired_) return interrupt();
  Segment& segment = segments_[point.segment];
  const auto cycle =
      static_cast<std::size_t>(std::lround(std::max(point.shape_time_s, 0.0) * segment.cycles_per_s));
  if (cycle < plan->phases) return interrupt();      // in the first period, the loop still settles
  if (cycle != segment.last_cycle + 1) interrupt();  // the sample of the cycle before is missing
  segment.last_cycle = cycle;
  take(point.segment, segment.phase_at(point.shape_time_s), *error_um);
}

void Learning::interrupt() {
  for (Segment& segment : segments_) {
    segment.valid = 0;
    segment.judgement.present = {};
  }
}

void Learning::take(std::size_t index, const Phase& phase, double error_um) {
  const Plan& plan = config_.plans[index];
  Segment& segment = segments_[index];
  const std::size_t window = plan.taps.size();
  if (++segment.newest == window) segment.newest = 0;
  segment.errors_um[segment.newest] = segment.errors_um[segment.newest + window] =
      static_cast<float>(error_um);
  segment.valid = segment.judgement.is_glitch(error_um) ? 0 : std::min(segment.valid + 1, window);
  tally(segment, plan, error_um);
  if (segment.valid < window || config_.frozen || segment.judgement.is_idle()) return;
  const auto taps = static_cast<Eigen::Index>(window);
  const Eigen::Map<const Eigen::VectorXf> h(segment.taps.data(), taps);
  const Eigen::Map<const Eigen::VectorXf> errors(segment.errors_um.data() + segment.newest + 1, taps);
  const double rate = std::ldexp(config_.rate, -static_cast<int>(segment.judgement.failed));
  const double learnt_um = rate * static_cast<double>(h.dot(errors));
  const std::size_t late = window / 2;  // K, half the length of the filter
  const std::size_t learnt = phase.index >= late ? phase.index - late : phase.index + plan.phases - late;
  correct(segment, learnt, 1.0 - phase.share, learnt_um);
  correct(segment, segment.after(learnt), phase.share, learnt_um);
}

void Learning::correct(Segment& segment, std::size_t phase, double share, double learnt_um) {
  double& correction_um = segment.correction_um[phase];
  correction_um += share * (learnt_um - 0.01 * config_.forget_percent * correction_um);
  correction_um = std::clamp(correction_um, -config_.correction_max_um, config_.correction_max_um);
}

bool Learning::Judgement::has_ended() const { return failed >= most_attempts; }

bool Learning::Judgement::is_idle() const { return resting > 0 || has_ended(); }

bool Learning::Judgement::is_glitch(double error_um) const {
  return is_known && std::abs(error_um) > glitch_factor * first_largest_um;
}

void Learning::tally(Segment& segment, const Plan& plan, double error_um) {
  Judgement& judgement = segment.judgement;
  metrics::ErrorStatistics& present = judgement.present;
  if (present.samples == std::max(plan.phases, plan.judged)) {
    conclude(segment);
    present = {};
  }
  const double counted_um =
      judgement.is_glitch(error_um) ? glitch_factor * judgement.first_largest_um : error_um;
  ++present.samples;
  present.sum_of_squares += counted_um * counted_um;
  present.max_um = std::max(present.max_um, std::abs(error_um));
}

void Learning::conclude(Segment& segment) {
  Judgement& judgement = segment.judgement;
  const double rms_um = judgement.present.rms_um();
  const bool is_without_learning = !judgement.is_known || judgement.resting > 0;
  judgement.is_known = true;
  if (judgement.resting > 0) --judgement.resting;
  if (is_without_learning) {
    judgement.first_rms_um = rms_um;
    judgement.first_largest_um = judgement.present.max_um;
  }
  judgement.grown = rms_um > grown_factor * judgement.first_rms_um ? judgement.grown + 1 : 0;
  ++report_.periods;
  report_.rms_um = rms_um;
  report_.first_rms_um = judgement.first_rms_um;
  report_.correction_max_um = 0.0;
  for (const double correction_um : segment.correction_um)
    report_.correction_max_um = std::max(report_.correction_max_um, std::abs(correction_um));
  report_.segment = static_cast<std::size_t>(&segment - segments_.data());
  if (judgement.grown >= grown_periods && report_.correction_max_um > 0.0 && !config_.frozen)
    take_back(segment);
}

void Learning::take_back(Segment& segment) {
  std::ranges::fill(segment.correction_um, 0.0);
  segment.judgement.resting = rest_periods;
  ++segment.judgement.failed;
}

void Learning::reset() {
  for (Segment& segment : segments_) {
    std::ranges::fill(segment.correction_um, 0.0);
    segment.judgement = {};
  }
  interrupt();
  now_.follows = ahead_.follows = false;
  report_ = {.correction_um = report_.correction_um};
}

void Learning::continue_from(const Learning& before) {
  report_ = before.report_;
  for (const auto& [own, its] : {std::pair(&now_, &before.now_), std::pair(&ahead_, &before.ahead_)})
    *own = {.last_um = its->last_um};
  for (std::size_t i = 0; i < std::min(segments_.size(), before.segments_.size()); ++i) {
    if (segments_[i].correction_um.size() != before.segments_[i].correction_um.size()) continue;
    std::ranges::copy(before.segments_[i].correction_um, segments_[i].correction_um.begin());
    segments_[i].judgement = before.segments_[i].judgement;
    segments_[i].judgement.present = {};
  }
}

Learning::Report Learning::report() const {
  Report report = report_;
  const auto has_ended = [](const Segment& segment) { return segment.judgement.has_ended(); };
  const bool is_resting =
      report_.segment < segments_.size() && segments_[report_.segment].judgement.resting > 0;
  report.state = std::ranges::any_of(segments_, has_ended) ? LearningState::diverged
                 : config_.frozen                          ? LearningState::frozen
                 : is_resting                              ? LearningState::resting
                                                           : LearningState::learning;
  return report;
}

std::vector<std::vector<double>> Learning::table() const {
  std::vector<std::vector<double>> table;
  table.reserve(segments_.size());
  for (const Segment& segment : segments_) table.push_back(segment.correction_um);
  return table;
}

bool Learning::restore(const std::vector<std::vector<double>>& table) {
  if (table.size() != segments_.size()) return false;
  for (std::size_t i = 0; i < table.size(); ++i)
    if (table[i].size() != segments_[i].correction_um.size()) return false;
  for (std::size_t i = 0; i < table.size(); ++i)
    std::ranges::transform(table[i], segments_[i].correction_um.begin(), [&](double correction_um) {
      return std::clamp(correction_um, -config_.correction_max_um, config_.correction_max_um);
    });
  return true;
}

}  // namespace hystcan::controller
