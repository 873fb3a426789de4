#include "controller/analysis/loop_design.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/text.h"

namespace hystcan::controller {
namespace {

using Complex = std::complex<double>;

/// Number of frequencies at which a loop is evaluated, as a share of the number in margins_of(): in the
/// coarse search for a low pass or a notch, and in the exact search for the gains.
constexpr double search_density = 0.15, exact_density = 0.6;

/// Largest ratio kp / (ki T) of the gains that is tried; T: cycle.
constexpr double largest_ratio = 6.0;

/// Returns the value with three significant digits, rounded towards zero.
double rounded_down(double value) {
  if (value <= 0.0) return 0.0;
  const double digits = 2.0 - std::floor(std::log10(value));
  const double down = std::floor(value * std::pow(10.0, digits) * (1.0 + 1e-12));
  // Shifts the decimal point of `down` by a positive power of 10, because 10 is exact as a double, but 0.1 is
  // not. For example, 46 / 10 is the double nearest to 4.6, but 46 * 0.1 is not.
  return digits < 0.0 ? down * std::pow(10.0, -digits) : down / std::pow(10.0, digits);
}

/// The response of the plant at every corner of the uncertainty and every frequency. It is computed once for
/// all filters that are tried.
struct Plants {
  std::vector<double> theta;
  std::vector<Complex> response;
};

Plants plants_of(const LoopConfig& config, const PlantUncertainty& uncertainty, double density) {
  Plants plants;
  for (const LinearLoop& corner : corners_of(config, uncertainty))
    for (const double theta : frequencies_for(corner.config(), density)) {
      plants.theta.push_back(theta);
      plants.response.push_back(corner.unfiltered(theta));
    }
  return plants;
}

/// Returns the open loop without its gains, with the filters of `config`, at all frequencies of all corners.
Responses responses_of(const LoopConfig& config, const Plants& plants) {
  const LinearLoop loop(config);
  const auto count = static_cast<Eigen::Index>(plants.theta.size());
  Responses of{Eigen::ArrayXcd(count), Eigen::ArrayXcd(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const double theta = plants.theta[static_cast<std::size_t>(i)];
    const Complex plant = loop.filtered(theta, plants.response[static_cast<std::size_t>(i)]),
                  z = std::polar(1.0, theta);
    of.proportional[i] = plant;
    of.integral[i] = plant * z / (z - 1.0);
  }
  return of;
}

/// Returns the largest ki T that does not exceed `peak_sensitivity` if kp / (ki T) is `ratio`; T: cycle. The
/// loop with ki T = 1 is `integral` + `ratio` times `proportional`. The equation is in loop_design.h.
double largest_ki(const Responses& of, double ratio, double peak_sensitivity) {
  const double rest = 1.0 - 1.0 / (peak_sensitivity * peak_sensitivity);
  double most = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < of.integral.size(); ++i) {
    const Complex x = of.integral[i] + ratio * of.proportional[i];
    if (x.real() >= 0.0) continue;
    const double square = std::norm(x), discriminant = x.real() * x.real() - square * rest;
    if (discriminant > 0.0) most = std::min(most, (-x.real() - std::sqrt(discriminant)) / square);
  }
  return most;
}

/// A ratio kp / (ki T) of the gains, and the largest ki T with this ratio; T: cycle.
struct Best {
  double ratio = 0.0;
  double ki_per_cycle = 0.0;
};
/// Tries `count` ratios kp / (ki T) in steps of `step`, starting at `from`. Returns the ratio that allows the
/// largest ki T without exceeding `peak_sensitivity`. T: cycle.
Best best_ratio(const Responses& of, double peak_sensitivity, double from, double step, int count) {
  Best best;
  for (int i = 0; i < count; ++i) {
    const double ratio = from + step * i;
    if (ratio < 0.0) continue;
    const double ki_per_cycle = largest_ki(of, ratio, peak_sensitivity);
    if (std::isfinite(ki_per_cycle) && ki_per_cycle > best.ki_per_cycle) best = {ratio, ki_per_cycle};
  }
  return best;
}

constexpr int coarse_ratios = 25;
constexpr double coarse_step = largest_ratio / (coarse_ratios - 1);

void require(const SensitivityRule& rule) {
  if (!(rule.peak_sensitivity > 1.0) || !std::isfinite(rule.peak_sensitivity))
    refuse("peak_sensitivity = ", rule.peak_sensitivity, ", expected more than 1");
}

/// Returns the largest ki T with the filters of `config`, found by a coarse search; T: cycle.
double worth(const LoopConfig& config, const Plants& plants, const SensitivityRule& rule) {
  const Responses of = responses_of(config, plants);
  return best_ratio(of, rule.peak_sensitivity, 0.0, coarse_step, coarse_ratios).ki_per_cycle;
}

/// Returns `config` with the low pass that allows the largest ki. Returns `config` unchanged if no low pass
/// improves it.
LoopConfig with_low_pass(const LoopConfig& config, const PlantUncertainty& uncertainty,
                         const SensitivityRule& rule) {
  constexpr std::array shares_of_rate{0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3};
  LoopConfig best = config, tried = config;
  const Plants plants = plants_of(config, uncertainty, search_density);
  double most = worth(config, plants, rule);
  for (const double share : shares_of_rate) {
    tried.measurement_filter_Hz = rounded_down(share / config.cycle_s);
    const double now = worth(tried, plants, rule);
    if (now > most) {
      most = now;
      best = tried;
    }
  }
  return best;
}

/// Depths of the notches that are tried; a depth is the gain at the notch frequency. A shallow notch delays
/// less, which is better if the mode is well damped or near half the rate.
constexpr std::array deep_notches{0.02, 0.1, 0.3};
constexpr std::array shallow_notches{0.6};

/// Returns `config` with the notch of one of these depths that allows the largest ki. Returns `config`
/// unchanged if no notch improves it.
LoopConfig with_notch(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const SensitivityRule& rule, std::span<const double> depths) {
  constexpr std::array places{0.9, 0.95, 1.0, 1.05};
  constexpr std::array widths{0.1, 0.2, 0.35, 0.6, 1.0};
  const double highest_Hz = 0.49 / config.cycle_s;
  LoopConfig best = config, tried = config;
  const Plants plants = plants_of(config, uncertainty, search_density);
  double most = worth(config, plants, rule);
  for (const double place : places)
    for (const double depth : depths)
      for (const double width : widths) {
        const double frequency_Hz = std::min(place * config.delays.resonance_Hz, highest_Hz);
        tried.notch =
            Notch::Config{.frequency_Hz = rounded_down(frequency_Hz), .depth = depth, .width = width};
        const double now = worth(tried, plants, rule);
        if (now > most) {
          most = now;
          best = tried;
        }
      }
  return best;
}

/// Returns copies of `config`, each with another notch that cancels the mode. The zeros of each notch are at
/// the mode's frequency and have twice its damping ratio. Each copy has one of the `widths`, which is the
/// damping ratio of the notch's poles.
std::vector<LoopConfig> with_cancelling_notches(const LoopConfig& config) {
  constexpr std::array widths{0.2, 0.35, 0.6, 1.0};
  const double frequency_Hz = std::min(config.delays.resonance_Hz, 0.49 / config.cycle_s);
  std::vector<LoopConfig> notched;
  for (const double width : widths) {
    const double depth = std::clamp(2.0 * config.delays.damping_ratio / width, 0.02, 0.5);
    notched.push_back(config);
    notched.back().notch = Notch::Config{
        .frequency_Hz = rounded_down(frequency_Hz), .depth = rounded_down(depth), .width = width};
  }
  return notched;
}

bool has_filter(const LoopConfig& config) { return config.notch || config.measurement_filter_Hz > 0.0; }

void require(const CautiousRule& rule) {
  if (!(rule.phase_margin_deg > 0.0 && rule.phase_margin_deg < 90.0))
    refuse("phase_margin_deg = ", rule.phase_margin_deg, ", expected more than 0 and less than 90");
  if (!(rule.gain_margin > 1.0)) refuse("gain_margin = ", rule.gain_margin, ", expected more than 1");
}

/// Returns the resonance frequencies, in Hz, of the plants that corners_of() returns.
std::vector<double> resonances_of(const model::Interval& resonance_Hz, double cycle_s) {
  constexpr int fewest = 5;
  // `share_of_rate`: maximum difference of two neighbouring resonances in the result, if a resonance can be
  // above half the rate. `without_mode`: a resonance so high that the plant behaves as if it had no mode.
  // Both are multiples of the rate.
  constexpr double share_of_rate = 0.02, without_mode = 1e3;
  const double rate_Hz = 1.0 / cycle_s, half_Hz = 0.5 * rate_Hz;
  const bool has_end = std::isfinite(resonance_Hz.hi);
  const double last_Hz = std::min(resonance_Hz.hi, std::max(resonance_Hz.lo, half_Hz) + rate_Hz);
  const double way_Hz = last_Hz - resonance_Hz.lo;
  const bool folds = last_Hz > half_Hz;
  const int count =
      folds ? std::max(fewest, 1 + static_cast<int>(std::ceil(way_Hz / (share_of_rate * rate_Hz)))) : fewest;
  std::vector<double> resonances(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    resonances[static_cast<std::size_t>(i)] = resonance_Hz.lo + way_Hz * i / (count - 1);
  if (!has_end) resonances.push_back(without_mode * rate_Hz);
  return resonances;
}

/// Returns the largest ki T that satisfies the cautious rule; T: cycle. `shape` is the open loop with ki
/// T = 1.
double largest_factor(const Eigen::ArrayXcd& shape, const CautiousRule& rule) {
  constexpr double pi = std::numbers::pi, on_the_real_axis = -pi + 1e-9;
  const double limit = rule.phase_margin_deg * pi / 180.0 - pi;
  double phase = std::arg(shape[0]), worst = 1e-300;
  for (Eigen::Index i = 0; i < shape.size(); ++i) {
    if (i > 0) phase += std::arg(shape[i] / shape[i - 1]);
    if (phase <= limit) worst = std::max(worst, std::abs(shape[i]));
    if (phase <= on_the_real_axis) worst = std::max(worst, rule.gain_margin * std::abs(shape[i]));
  }
  return 1.0 / worst;
}

}  // namespace

PlantUncertainty widened(PlantUncertainty uncertainty, double percent) {
  uncertainty.resonance_Hz.lo *= 1.0 - 0.01 * percent;
  uncertainty.resonance_Hz.hi *= 1.0 + 0.01 * percent;
  return uncertainty;
}

PlantUncertainty around(const Delays& delays, double percent) {
  return widened({.resonance_Hz = {delays.resonance_Hz, delays.resonance_Hz},
                  .damping_ratio = {delays.damping_ratio, delays.damping_ratio}},
                 percent);
}

bool PlantUncertainty::shows_mode() const { return std::isfinite(resonance_Hz.hi); }

std::vector<LinearLoop> corners_of(const LoopConfig& config, const PlantUncertainty& uncertainty) {
  std::vector<LinearLoop> corners{LinearLoop(config)};
  const auto& [resonance, damping, longer] = uncertainty;
  for (const double resonance_Hz : resonances_of(resonance, config.cycle_s))
    for (const double zeta : {damping.lo, damping.hi})
      for (const double longer_s : {longer.lo, longer.hi}) {
        LoopConfig corner = config;
        corner.delays.resonance_Hz = resonance_Hz;
        corner.delays.damping_ratio = zeta;
        corners.emplace_back(corner, longer_s);
        if (longer.span() == 0.0) break;
      }
  return corners;
}

PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const SensitivityRule& rule) {
  require(rule);
  const Responses of =
      responses_of(config, plants_of(config, widened(uncertainty, rule.resonance_percent), exact_density));
  const Best coarse = best_ratio(of, rule.peak_sensitivity, 0.0, coarse_step, coarse_ratios);
  const double fine = coarse_step / 10.0;
  const Best best = best_ratio(of, rule.peak_sensitivity, coarse.ratio - coarse_step, fine, 21);
  return {.kp = rounded_down(best.ratio * best.ki_per_cycle),
          .ki_per_s = rounded_down(best.ki_per_cycle / config.cycle_s)};
}

PiGains largest_gains(const LoopConfig& config, const PlantUncertainty& uncertainty,
                      const CautiousRule& rule) {
  require(rule);
  const Responses of = responses_of(LinearLoop(config));
  Best best;
  for (int i = 0; i <= 250; ++i) {
    const double ratio = 0.02 * i;
    const double ki_per_cycle = largest_factor(of.integral + ratio * of.proportional, rule);
    if (ki_per_cycle > best.ki_per_cycle) best = {ratio, ki_per_cycle};
  }
  // A mode above half the rate appears in the samples at an alias. There, the phase of L rises with the
  // frequency instead of falling, so the loop at a corner may allow only lower gains than the loop of
  // `config`.
  const bool folds = uncertainty.resonance_Hz.hi * config.cycle_s > 0.5;
  if (folds)
    for (const LinearLoop& corner : corners_of(config, uncertainty)) {
      const Responses there = responses_of(corner);
      best.ki_per_cycle =
          std::min(best.ki_per_cycle, largest_factor(there.integral + best.ratio * there.proportional, rule));
    }
  return {.kp = rounded_down(best.ratio * best.ki_per_cycle),
          .ki_per_s = rounded_down(best.ki_per_cycle / config.cycle_s)};
}

PiGains unmeasured_gains(const LoopConfig& config, const PlantUncertainty& uncertainty) {
  constexpr double share = 0.125;
  double most_per_s = std::numeric_limits<double>::infinity();
  for (const LinearLoop& corner : corners_of(config, uncertainty))
    most_per_s = std::min(most_per_s, largest_stable_gains(corner, {}).ki_per_s);
  return {.ki_per_s = rounded_down(share * most_per_s)};
}

std::vector<LoopConfig> designs(const LoopConfig& config, const PlantUncertainty& uncertainty,
                                const SensitivityRule& rule) {
  require(rule);
  const PlantUncertainty corners = widened(uncertainty, rule.resonance_percent);
  LoopConfig plain = config;
  plain.measurement_filter_Hz = 0.0;
  plain.notch.reset();
  std::vector<LoopConfig> filtered;
  if (corners.shows_mode()) filtered = with_cancelling_notches(plain);
  const auto add = [&](const LoopConfig& one) {
    if (has_filter(one)) filtered.push_back(one);
  };
  add(with_low_pass(plain, corners, rule));
  if (corners.shows_mode()) {
    add(with_notch(plain, corners, rule, deep_notches));
    add(with_notch(plain, corners, rule, shallow_notches));
  }
  plain.pi = largest_gains(plain, uncertainty, rule);
  std::vector<LoopConfig> better{plain};
  for (LoopConfig& one : filtered) {
    one.pi = largest_gains(one, uncertainty, rule);
    if (one.pi.ki_per_s > plain.pi.ki_per_s) better.push_back(one);
  }
  std::ranges::stable_sort(better, std::greater{}, [](const LoopConfig& of) { return of.pi.ki_per_s; });
  return better;
}

JudgedLoop judge(const LoopConfig& config, const PlantUncertainty& uncertainty) {
  const Margins margins = margins_of(LinearLoop(config), config.pi);
  JudgedLoop judged{.margins = margins, .worst = margins};
  for (const LinearLoop& corner : corners_of(config, uncertainty))
    judged.worst = worse_of(judged.worst, margins_of(corner, config.pi));
  return judged;
}

}  // namespace hystcan::controller
