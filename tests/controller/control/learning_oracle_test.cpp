// Learning compared with a naive implementation of its description: the whole history instead of windows, and
// lists of errors instead of sums. Plans, errors and disturbances are drawn at random.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "controller/control/learning.h"

namespace hystcan::controller::learning_oracle_test {
namespace {

constexpr double cycle_s = 1.0 / 1024.0, ends_s = 0.01, fade_s = 0.02;

double smooth(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
}

double rms_of(const std::vector<double>& errors_um) {
  const double sum = std::inner_product(errors_um.begin(), errors_um.end(), errors_um.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(errors_um.size()));
}

double largest_of(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

class NaiveLearning {
 public:
  explicit NaiveLearning(const Learning::Config& config) : config_(config), segments_(config.plans.size()) {
    for (std::size_t i = 0; i < segments_.size(); ++i)
      if (!config.plans[i].taps.empty()) segments_[i].correction_um.assign(config.plans[i].phases, 0.0);
  }

  double now_um(const Trajectory::Point& point, double dt_s) { return put_out(now_, point, dt_s); }
  double ahead_um(const Trajectory::Point& point, double dt_s) { return put_out(ahead_, point, dt_s); }

  void learn(const Trajectory::Point& point, std::optional<double> error_um, bool undisturbed) {
    const auto cycle = std::lround(point.shape_time_s / cycle_s);
    if (!repeats(point) || !error_um || !undisturbed ||
        cycle < static_cast<long>(config_.plans[point.segment].phases)) {
      disturb();
      return;
    }
    Segment& segment = segments_[point.segment];
    if (cycle != segment.last_cycle + 1) disturb();
    segment.last_cycle = cycle;
    take(point, *error_um);
  }

  void reset() {
    for (Segment& segment : segments_) {
      std::ranges::fill(segment.correction_um, 0.0);
      segment = {.correction_um = segment.correction_um, .last_cycle = segment.last_cycle};
    }
    now_.follows = ahead_.follows = false;
    report_ = {.correction_um = report_.correction_um};
  }

  const std::vector<double>& correction_um(std::size_t segment) const {
    return segments_[segment].correction_um;
  }
  Learning::Report report() const {
    Learning::Report report = report_;
    bool has_ended = false;
    for (const Segment& segment : segments_) has_ended = has_ended || segment.failed >= 3;
    report.state = has_ended                               ? LearningState::diverged
                   : config_.frozen                        ? LearningState::frozen
                   : segments_[report.segment].resting > 0 ? LearningState::resting
                                                           : LearningState::learning;
    return report;
  }

 private:
  struct Segment {
    std::vector<double> correction_um{};
    long last_cycle = -1;
    std::vector<double> window_um{}, period_um{};  ///< errors of the present period, in a run without a gap
    bool is_known = false;                         ///< error without learning
    double first_rms_um = 0.0, first_largest_um = 0.0;
    int grown = 0, resting = 0, failed = 0;
  };
  struct Output {
    double last_um = 0.0, fading_um = 0.0;
    bool follows = false;
  };

  bool repeats(const Trajectory::Point& point) const {
    return !point.in_transition && !point.finished && !point.live && point.segment < segments_.size() &&
           !config_.plans[point.segment].taps.empty();
  }
  void disturb() {
    for (Segment& segment : segments_) segment.window_um.clear(), segment.period_um.clear();
  }
  /// Returns the number of phases from the start of the period to the time.
  double phases_at(const Trajectory::Point& point) const {
    const Learning::Plan& plan = config_.plans[point.segment];
    const auto count = static_cast<double>(plan.phases);
    const double period_s = plan.period_s > 0.0 ? plan.period_s : count * cycle_s;
    return std::fmod(point.shape_time_s * (count / period_s), count);
  }

  double put_out(Output& output, const Trajectory::Point& point, double dt_s) {
    const bool follows =
        repeats(point) && segments_[point.segment].resting == 0 && segments_[point.segment].failed < 3;
    double target_um = 0.0;
    if (follows) {
      const Segment& segment = segments_[point.segment];
      const double phases = phases_at(point), share = phases - std::floor(phases);
      const auto index = static_cast<std::size_t>(phases);
      const double left_s = config_.plans[point.segment].duration_s - point.shape_time_s;
      target_um = smooth(point.shape_time_s / ends_s) * smooth(left_s / ends_s) *
                  ((1.0 - share) * segment.correction_um[index] +
                   share * segment.correction_um[(index + 1) % segment.correction_um.size()]);
    }
    if (follows != output.follows) output.fading_um = output.last_um - target_um;
    output.follows = follows;
    output.fading_um *= std::max(0.0, 1.0 - dt_s / fade_s);
    output.last_um = target_um + output.fading_um;
    if (&output == &now_) report_.correction_um = output.last_um;
    return output.last_um;
  }

  static bool is_glitch(const Segment& segment, double error_um) {
    return segment.is_known && std::abs(error_um) > 4.0 * segment.first_largest_um;
  }

  void take(const Trajectory::Point& point, double error_um) {
    const Learning::Plan& plan = config_.plans[point.segment];
    Segment& segment = segments_[point.segment];
    segment.window_um.push_back(error_um);
    if (is_glitch(segment, error_um)) segment.window_um.clear();
    if (segment.period_um.size() == std::max(plan.phases, plan.judged)) {
      conclude(point.segment);
      segment.period_um.clear();
    }
    segment.period_um.push_back(error_um);
    if (segment.window_um.size() < plan.taps.size() || config_.frozen || segment.resting > 0 ||
        segment.failed >= 3)
      return;
    const double learnt_um =
        config_.rate * std::pow(0.5, segment.failed) *
        std::inner_product(plan.taps.begin(), plan.taps.end(),
                           segment.window_um.end() - static_cast<long>(plan.taps.size()), 0.0);
    const double phases = phases_at(point), share = phases - std::floor(phases);
    const std::size_t index =
        (static_cast<std::size_t>(phases) + plan.phases - plan.taps.size() / 2) % plan.phases;
    add(segment.correction_um[index], 1.0 - share, learnt_um);
    add(segment.correction_um[(index + 1) % plan.phases], share, learnt_um);
  }

  void add(double& correction_um, double share, double learnt_um) const {
    correction_um =
        std::clamp(correction_um + share * (learnt_um - config_.forget_percent / 100.0 * correction_um),
                   -config_.correction_max_um, config_.correction_max_um);
  }

  void conclude(std::size_t index) {
    Segment& segment = segments_[index];
    std::vector<double> counted_um = segment.period_um;
    for (double& error_um : counted_um)
      if (is_glitch(segment, error_um)) error_um = 4.0 * segment.first_largest_um;
    const double rms_um = rms_of(counted_um);
    if (!segment.is_known || segment.resting > 0) {
      segment.first_rms_um = rms_um;
      segment.first_largest_um = largest_of(segment.period_um);
    }
    segment.is_known = true;
    segment.resting = std::max(0, segment.resting - 1);
    segment.grown = rms_um > 1.3 * segment.first_rms_um ? segment.grown + 1 : 0;
    const double largest_um = largest_of(segment.correction_um);
    report_ = {.periods = report_.periods + 1,
               .segment = index,
               .rms_um = rms_um,
               .first_rms_um = segment.first_rms_um,
               .correction_um = report_.correction_um,
               .correction_max_um = largest_um};
    if (segment.grown < 3 || largest_um == 0.0 || config_.frozen) return;
    std::ranges::fill(segment.correction_um, 0.0);
    segment.grown = 0;
    segment.resting = 3;
    ++segment.failed;
  }

  Learning::Config config_;
  std::vector<Segment> segments_;
  Learning::Report report_;
  Output now_, ahead_;
};

/// The random values of one run.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  bool happens(double probability) { return std::bernoulli_distribution(probability)(random_); }
  std::size_t whole(std::size_t least, std::size_t most) {
    return std::uniform_int_distribution<std::size_t>(least, most)(random_);
  }
  double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }

  Learning::Config config() {
    Learning::Config config{.rate = between(0.2, 1.0),
                            .forget_percent = happens(0.5) ? 0.0 : between(0.0, 20.0),
                            .correction_max_um = happens(0.3) ? 0.05 : 10.0,
                            .frozen = happens(0.1)};
    for (int i = 0; i < 3; ++i) {
      Learning::Plan& plan = config.plans.emplace_back();
      plan.phases = whole(7, 30);
      plan.cycle_s = cycle_s;
      if (happens(0.3)) plan.period_s = (static_cast<double>(plan.phases) + between(-0.4, 0.4)) * cycle_s;
      if (happens(0.3)) plan.judged = whole(1, 60);
      plan.duration_s = between(1.0, 1.5);
      if (i == 1 && happens(0.5)) continue;  // a shape that does not repeat
      for (std::size_t k = 2 * whole(0, 3) + 1; k > 0; --k) plan.taps.push_back(between(-0.2, 0.4));
      plan.taps[plan.taps.size() / 2] = 1.0;
    }
    return config;
  }

 private:
  std::mt19937 random_;
};

void expect_equal(const Learning& learning, const NaiveLearning& naive, std::size_t segments) {
  const Learning::Report own = learning.report(), other = naive.report();
  ASSERT_EQ(own.state, other.state);
  ASSERT_EQ(own.periods, other.periods);
  ASSERT_EQ(own.segment, other.segment);
  ASSERT_NEAR(own.rms_um, other.rms_um, 1e-4);
  ASSERT_NEAR(own.first_rms_um, other.first_rms_um, 1e-4);
  ASSERT_NEAR(own.correction_um, other.correction_um, 1e-4);
  ASSERT_NEAR(own.correction_max_um, other.correction_max_um, 1e-4);
  const std::vector<std::vector<double>> table = learning.table();
  for (std::size_t i = 0; i < segments; ++i) {
    ASSERT_EQ(table[i].size(), naive.correction_um(i).size());
    for (std::size_t j = 0; j < table[i].size(); ++j)
      ASSERT_NEAR(table[i][j], naive.correction_um(i)[j], 1e-4);
  }
}

/// A run of some seconds: consecutive segments, with errors that the correction reduces or increases.
void expect_agreement(unsigned seed, int& diverged, int& rested) {
  Draw draw(seed);
  const Learning::Config config = draw.config();
  Learning learning(config);
  NaiveLearning naive(config);
  Trajectory::Point point;
  double gain = 1.0;
  const auto disturbed = [&] { return draw.happens(0.002); };
  for (int i = 0; i < 6000; ++i) {
    if (point.shape_time_s >= config.plans[std::min<std::size_t>(point.segment, 2)].duration_s ||
        draw.happens(3e-4)) {
      point.segment = draw.whole(0, 3);
      point.shape_time_s = 0.0;
      gain = draw.happens(0.5) ? 1.0 : draw.between(-3.0, 3.0);
    }
    Trajectory::Point now = point, ahead = point;
    now.in_transition = disturbed();
    now.live = disturbed();
    now.finished = disturbed();
    ahead.shape_time_s += 3.0 * cycle_s;
    const double dt_s = draw.happens(0.01) ? draw.between(0.0, 0.03) : cycle_s;
    const Learning::Correction correction = learning.correct(now, ahead, dt_s);
    ASSERT_NEAR(correction.now_um, naive.now_um(now, dt_s), 1e-4);
    ASSERT_NEAR(correction.ahead_um, naive.ahead_um(ahead, dt_s), 1e-4);
    double error_um = 0.1 * std::sin(point.shape_time_s * 300.0) + 0.01 - gain * correction.now_um;
    if (draw.happens(0.003)) error_um += draw.happens(0.5) ? 2.0 : -2.0;
    const std::optional<double> sample = disturbed() ? std::nullopt : std::optional(error_um);
    const bool undisturbed = !disturbed();
    learning.learn(now, sample, undisturbed);
    naive.learn(now, sample, undisturbed);
    if (draw.happens(2e-4)) learning.reset(), naive.reset();
    if (i % 50 == 0) expect_equal(learning, naive, config.plans.size());
    if (testing::Test::HasFatalFailure()) FAIL() << "cycle " << i;
    diverged += naive.report().state == LearningState::diverged ? 1 : 0;
    rested += naive.report().state == LearningState::resting ? 1 : 0;
    point.shape_time_s += draw.happens(0.001) ? 2.0 * cycle_s : cycle_s;
  }
}

TEST(LearningOracle, AgreesWithANaiveImplementation) {
  int diverged = 0, rested = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    expect_agreement(seed, diverged, rested);
    if (HasFatalFailure()) FAIL() << "seed " << seed;
  }
  EXPECT_GT(diverged, 1000);
  EXPECT_GT(rested, 1000);
}

}  // namespace
}  // namespace hystcan::controller::learning_oracle_test
