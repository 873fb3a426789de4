#include "controller/analysis/learning_design.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text.h"
#include "controller/analysis/loop_design.h"

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;
constexpr double half_turn = std::numbers::pi;

constexpr int half_grid = 768;  ///< number of frequency steps from 0 to pi (half the rate)
constexpr std::size_t most_taps = 97;
constexpr double regularisation = 0.02;

/// In each period, learning multiplies the error at a frequency by a factor. Returns the upper limit of this
/// factor in the band that LearningDesign::highest_Hz reports. At the default learning rate, an error with
/// the returned factor falls to a tenth within 20 periods. With a lower learning rate, the returned factor is
/// larger.
double soon(double rate) { return 1.0 - 0.109 * rate / Learning::Config{}.rate; }

/// Tolerance in cycles: a number of cycles that is this close to a whole number counts as whole.
constexpr double near_enough = 0.01;

/// Minimum number of periods that a segment must have after the periods in which it settles. In fewer
/// periods, nothing would be learnt.
constexpr double settling_periods = 1.5;

double theta_of(int i, int half) { return half_turn * i / half; }

/// Returns by how many whole cycles the feed-forward must use a learnt correction early, so that the
/// correction acts on the right sample: the mean delay from a command to the sample that shows its effect.
double ahead_cycles(const LoopConfig& loop) {
  return std::max(
      0.0, std::round((chain_moments(loop.delays, loop.notch, loop.cycle_s).mean_s + loop.delays.sensor_s()) /
                      loop.cycle_s));
}

/// The response of the loop to a correction of the reference, at every frequency, for one resonance of the
/// mode.
using LearningResponse = Eigen::ArrayXcd;

std::vector<LearningResponse> learning_responses(const LoopConfig& loop, double resonance_percent) {
  constexpr int resonances = 11;
  const double ahead = ahead_cycles(loop);
  std::vector<LearningResponse> all(resonances, LearningResponse(half_grid + 1));
  for (int i = 0; i < resonances; ++i) {
    LoopConfig actual = loop;
    actual.delays.resonance_Hz *= 1.0 + 0.01 * resonance_percent * (2.0 * i / (resonances - 1) - 1.0);
    const LinearLoop linear(actual);
    for (int k = 0; k <= half_grid; ++k) {
      const double theta = k == 0 ? 1e-9 : theta_of(k, half_grid);
      const Complex path = linear.plant(theta);
      const Complex forward = feeds_forward(loop.structure) ? std::polar(1.0, theta * ahead) : 0.0;
      const Complex feedback = feeds_back(loop.structure) ? linear(loop.pi, theta) : 0.0;
      all[static_cast<std::size_t>(i)][k] = (path * forward + feedback) / (1.0 + feedback);
    }
  }
  return all;
}

/// Returns the response of the learning filter before a low pass cuts it off: a regularised inverse of all
/// `responses` (learning_design.h).
Eigen::ArrayXcd inverse_of(const std::vector<LearningResponse>& responses) {
  Eigen::ArrayXcd h(half_grid + 1);
  for (int k = 0; k <= half_grid; ++k) {
    Complex lo(1e300, 1e300), hi(-1e300, -1e300);
    for (const LearningResponse& t : responses) {
      lo = {std::min(lo.real(), t[k].real()), std::min(lo.imag(), t[k].imag())};
      hi = {std::max(hi.real(), t[k].real()), std::max(hi.imag(), t[k].imag())};
    }
    const Complex middle = 0.5 * (lo + hi);
    double radius = 0.0;
    for (const LearningResponse& t : responses) radius = std::max(radius, std::abs(t[k] - middle));
    const double certain = std::max(0.0, 1.0 - radius / std::abs(middle));
    h[k] = certain * certain * std::conj(middle) / (std::norm(middle) + regularisation);
  }
  return h;
}

/// Returns the gain of a low pass: 1 below the corner, 0 above 1.5 times the corner, smooth in between.
/// `share` and `corner` are frequencies, as shares of half the rate.
double cut_off(double share, double corner) { return 1.0 - smooth_step((share / corner - 1.0) / 0.5); }

/// Returns the taps h_k of the filter with the response H(theta) = `response`. A low pass cuts H off at
/// `corner`, and a window is applied to the taps: h_k = 1 / (2 pi) integral H e^{-i theta k} dtheta. The
/// number of taps is odd, at most `phases` and at most most_taps.
std::vector<double> taps_of(const Eigen::ArrayXcd& response, double corner, std::size_t phases) {
  const std::size_t count = std::min(most_taps, phases - (phases % 2 == 0 ? 1 : 0));
  const int late = static_cast<int>(count / 2);
  std::vector<double> taps(count);
  for (std::size_t tap = 0; tap < count; ++tap) {
    const int k = static_cast<int>(tap) - late;
    double sum = 0.0;
    for (int i = 0; i <= half_grid; ++i) {
      const double theta = theta_of(i, half_grid), ends = i == 0 || i == half_grid ? 0.5 : 1.0;
      sum += ends * cut_off(theta / half_turn, corner) * (response[i] * std::polar(1.0, -theta * k)).real();
    }
    const double window = 0.5 + 0.5 * std::cos(half_turn * k / (late + 1.0));
    taps[tap] = window * sum / half_grid;
  }
  return taps;
}

/// Returns the response of the filter with these taps at the frequency `theta`.
Complex response_of(const std::vector<double>& taps, double theta) {
  const int late = static_cast<int>(taps.size() / 2);
  Complex sum = 0.0;
  for (std::size_t tap = 0; tap < taps.size(); ++tap)
    sum += taps[tap] * std::polar(1.0, theta * (static_cast<int>(tap) - late));
  return sum;
}

/// Checks the filter with its finite number of taps, and stores in `design` how fast it learns. Returns false
/// if an error would grow.
bool converges(const std::vector<LearningResponse>& responses, const Learning::Config& config, double cycle_s,
               LearningDesign& design) {
  const double forget = 0.01 * config.forget_percent;
  design.largest_growth = design.highest_Hz = design.slowest_Hz = 0.0;
  double slowest = 0.0;
  bool lower = true;
  for (int k = 0; k <= half_grid; ++k) {
    const double theta = theta_of(k, half_grid), frequency_Hz = theta / (2.0 * half_turn * cycle_s);
    const Complex h = response_of(design.plan.taps, theta);
    double growth = 0.0;
    for (const LearningResponse& t : responses)
      growth = std::max(growth, std::abs(1.0 - forget - config.rate * h * t[k]));
    design.largest_growth = std::max(design.largest_growth, growth);
    lower = lower && growth < soon(config.rate);
    if (!lower) continue;
    design.highest_Hz = frequency_Hz;
    if (growth > slowest) {
      slowest = growth;
      design.slowest_Hz = frequency_Hz;
    }
  }
  design.slowest_periods = slowest > 0.0 ? std::log(0.1) / std::log(slowest) : 0.0;
  return design.largest_growth <= 1.0 - 0.5 * forget;
}

/// Lowers the corner of the learning filter's low pass until the filter converges: no error grows from period
/// to period, at any frequency and resonance. Returns false if errors still grow with the lowest corner.
bool finds_filter(const std::vector<LearningResponse>& responses, const Learning::Config& config,
                  double cycle_s, LearningDesign& design) {
  const Eigen::ArrayXcd inverse = inverse_of(responses);
  constexpr int steps = 50;
  for (int step = 0; step < steps; ++step) {
    design.plan.taps = taps_of(inverse, 2.0 * std::pow(0.9, step), design.plan.phases);
    if (converges(responses, config, cycle_s, design)) return true;
  }
  return false;
}

/// Selects how many periods form one block, at most ten. Learning has one correction for each cycle of the
/// block, so the block must last a whole number of cycles: selects the smallest number of periods with this
/// property. If there is none, selects the number of periods whose duration is nearest to a whole number of
/// cycles. `cycles`: cycles of one period.
void set_phases(LearningDesign& design, double cycles) {
  constexpr unsigned most_periods = 10;
  design.slip_cycles = 1.0;
  for (unsigned periods = 1; periods <= most_periods; ++periods) {
    const double slip = std::abs(periods * cycles - std::round(periods * cycles));
    if (slip >= design.slip_cycles) continue;
    design.slip_cycles = slip;
    design.periods = periods;
    if (slip < near_enough) return;
  }
}

/// Returns over how many cycles Learning computes one RMS error, to decide if the error has grown.
/// design.periods periods form a block. Returns 0 (over one block) if a block is a whole number of cycles.
/// Otherwise a turning point of the reference moves relative to the samples from block to block, and the
/// error changes with it. The returned number is large enough for a turning point to move from one sample to
/// the next. It is limited to the cycles of 10 blocks.
std::size_t judged_cycles(const LearningDesign& design, double cycles) {
  constexpr double most_periods = 10.0;
  if (design.slip_cycles < near_enough) return 0;
  const double periods = std::min(1.0 / design.slip_cycles, most_periods) * design.periods;
  return static_cast<std::size_t>(std::lround(periods * cycles));
}

}  // namespace

std::optional<double> period_s(const Shape& shape) {
  const auto of = [](const auto& s) -> std::optional<double> {
    if constexpr (requires { s.frequency_Hz; }) return 1.0 / s.frequency_Hz;
    if constexpr (requires { s.line_rate_Hz; })
      return s.role == ScanRole::fast ? (s.both_directions ? 2.0 : 1.0) * s.line_s() : s.frame_s();
    return std::nullopt;
  };
  return std::visit(of, shape);
}

LearningDesign design_learning(const LoopConfig& loop, const Shape& shape, const Learning::Config& config) {
  constexpr double fewest_cycles = 4.0;
  const std::optional<double> period = period_s(shape);
  if (!period) refuse("a ", to_string(shape), " does not repeat, expected a shape with a frequency_Hz");
  const double cycles = *period / loop.cycle_s;
  if (!(cycles >= fewest_cycles && cycles <= longest_period_cycles))
    refuse("a period of ", cycles, " cycles, expected ", fewest_cycles, " to ", longest_period_cycles);
  LearningDesign design;
  design.resonance_percent = config.resonance_percent;
  set_phases(design, cycles);
  design.plan.cycle_s = loop.cycle_s;
  design.plan.duration_s = duration_s(shape);
  const double periods = design.plan.duration_s / *period;
  if (periods < design.periods + settling_periods)
    refuse("a ", to_string(shape), " of ", periods, " periods, expected ", design.periods + settling_periods,
           " or more: the first ", design.periods, " settle");
  const std::vector<LearningResponse> responses = learning_responses(loop, config.resonance_percent);
  const unsigned together = design.periods;
  // A block is one period or several, and a phase is a cycle of the block. The filter may have at most as
  // many taps as the block has phases, so a short block has a short filter. If no filter converges, the block
  // becomes longer: it contains more periods and allows a longer filter, but learns more slowly.
  do {
    design.plan.phases = static_cast<std::size_t>(std::lround(design.periods * cycles));
    design.plan.period_s = design.periods * *period;
    design.plan.judged = judged_cycles(design, cycles);
    if (finds_filter(responses, config, loop.cycle_s, design)) return design;
    design.periods += together;
  } while (design.plan.phases < most_taps && periods >= design.periods + settling_periods);
  refuse("no learning filter converges if the resonance differs from the configured one by ",
         config.resonance_percent, " %, expected a smaller resonance_percent, a notch, or less gain");
}

std::vector<std::optional<LearningDesign>> plan_learning(AxisConfig& axis, double rate_Hz) {
  std::vector<std::optional<LearningDesign>> designs(axis.setpoint.size());
  if (!axis.learning) return designs;
  const LoopConfig loop = loop_config_of(axis.law, axis.delays, 1.0 / rate_Hz);
  Learning::Config& learning = *axis.learning;
  learning.ahead_cycles = static_cast<std::size_t>(ahead_cycles(loop));
  learning.plans.assign(axis.setpoint.size(), {});
  for (std::size_t i = 0; i < designs.size(); ++i) {
    if (!period_s(axis.setpoint[i].shape)) continue;
    designs[i] = design_learning(loop, axis.setpoint[i].shape, learning);
    learning.plans[i] = designs[i]->plan;
  }
  if (std::ranges::none_of(designs, [](const auto& design) { return design.has_value(); }))
    refuse("no segment of the reference repeats, expected a triangle, a sine or a raster");
  return designs;
}

}  // namespace hystcan::controller
