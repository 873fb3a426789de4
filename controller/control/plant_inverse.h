// The feed-forward that inverts the plant with its mode, and the expected response of the plant.
//
//   u = V r:   u(t) = sum_k w_k r(t + mu + k T),  k = -8 .. 8
//   y = G u    the sample that the nominal plant predicts
//
//   r, u, y   reference, output of the feed-forward, and expected sample
//   V, w_k    feed-forward and its weights; mu: mean delay of the chain, T: cycle
//   G         nominal plant, from the demand to the sample
//
// PI and learning compare the sample with y instead of r. The two differ at the corners of r, which no drive
// that is set once per cycle can follow. With y, PI and learning do not undo the weighting of the
// feed-forward there.
//
// The plant has the poles p_i and is a recursion from cycle to cycle (controller/analysis/linear_loop.h):
//
//   held          y = u + sum_i x_i,                x_i <- e^{p_i T} x_i + s_i d u
//   interpolated  y = u_{-1} + c d u + sum_i x_i,   x_i <- e^{p_i T} x_i + s_i (d u - d u_{-1})
//
// u_{-1} is u in the last cycle, and d u the change of u since then. x_i is the state of pole i; s_i and c
// are constants of the plant (Term::share and Config::constant).
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <limits>

#include "controller/control/delays.h"

namespace hystcan::controller {

/// The feed-forward is a weighted sum of the references at the times t + mu + k T (t: present time, mu: mean
/// delay of the chain from demand to position, T: cycle). This constant is the largest k; the smallest k is
/// its negative.
inline constexpr int feed_forward_reach = 8;
/// The weights w_k of the references r(t + mu + k T) in the feed-forward, from k = -feed_forward_reach to
/// k = feed_forward_reach (t: present time, mu: mean delay of the chain from demand to position, T: cycle).
using FeedForwardWeights = std::array<double, 2 * feed_forward_reach + 1>;

/// The references that the feed-forward multiplies by its weights, one for each weight. In each cycle, only
/// the reference at the latest time is evaluated; the others were evaluated in earlier cycles. They stay
/// valid, because a new setpoint changes the reference only after the latest time that was evaluated.
class ReferenceWindow {
 public:
  void clear() { filled_ = false; }
  /// Returns the weighted sum of the reference around `t_s`. Called once per cycle. `reference(t_s)` returns
  /// the reference. Evaluates only the newest value of the sum if `t_s` is one cycle later than in the last
  /// call, with a tolerance of a quarter of a cycle; otherwise evaluates all values again.
  template <class Reference>
  double filtered(const FeedForwardWeights& weights, double t_s, double cycle_s, const Reference& reference);

 private:
  bool continues(double t_s, double cycle_s) const;
  void push(double value);

  /// Ring buffer of the references in the weighted sum. It contains each reference twice, so that the
  /// references from the oldest to the newest are always contiguous in memory.
  std::array<double, 2 * std::tuple_size_v<FeedForwardWeights>> values_{};
  std::size_t oldest_ = 0;
  double last_s_ = 0.0;
  bool filled_ = false;
};

/// The nominal plant from the demand to the sample, as a recursion from cycle to cycle.
struct PlantRecursion {
  struct Term {
    /// Factor s_i of the state x_i (see the top of this file). Each cycle adds to x_i this factor times the
    /// change of the input u; if `interpolated`, this factor times the change of that change. 0: x_i stays 0.
    std::complex<double> share;
    std::complex<double> decay;  ///< factor of x_i from cycle to cycle: e^{p T}; p: a pole, T: cycle
  };
  struct Config {
    int delay_cycles = 0;  ///< delay of the plant: its input is the drive of this many cycles ago
    bool interpolated = false;
    /// Used only if `interpolated`: the sample contains the last change of the drive times this factor c (see
    /// the top of this file).
    double constant = 0.0;
    std::array<Term, 4> terms{};
    Notch::Coefficients notch{};
  };
  struct State {
    double input = 0.0;
    double difference = 0.0;
    std::array<std::complex<double>, 4> terms{};
    Notch::State notch{};
  };

  static State at_rest(double input) { return {.input = input, .notch = Notch::at_rest(input)}; }
  static double step(const Config& config, State& state, double input);
};

/// The feed-forward that inverts the plant, and the expected sample, which a model of the plant computes from
/// cycle to cycle. The model is not restarted if a SYNC is late: a restart computes up to warm_up_cycles at
/// once, which would delay the next SYNC too.
class PlantInverse {
 public:
  struct Config {
    FeedForwardWeights feed_forward;
    PlantRecursion::Config plant;
  };

  explicit PlantInverse(const Config& config) : config_(config) {}

  /// Clears the state for a reference that rests until `rest_until_s`: the model of the plant then starts at
  /// rest at this time.
  void restart(double rest_until_s);
  /// Changes the plant while the reference moves: the model of the plant then starts warm_up_cycles before
  /// the present cycle.
  void retune(const Config& config);

  /// Returns the output of the feed-forward. `t_s`: present time plus the mean delay of the chain.
  template <class Reference>
  double feed_forward(double t_s, double cycle_s, const Reference& reference) {
    return ahead_.filtered(config_.feed_forward, t_s, cycle_s, reference);
  }
  /// Returns the sample that the nominal plant predicts for this cycle. `t_s`: present time plus the mean
  /// delay.
  template <class Reference>
  double expected(double t_s, double cycle_s, const Reference& reference);

 private:
  static constexpr double warm_up_cycles = 128.0;
  /// Returns how many cycles before the present cycle the model of the plant must start, so that it starts
  /// while the reference is at rest; at most warm_up_cycles. `late_s`: time of the reference that is the
  /// plant's input in the present cycle.
  int cycles_since_rest(double late_s, double cycle_s) const;

  Config config_;
  ReferenceWindow ahead_, late_;
  PlantRecursion::State plant_;
  double rest_until_s_ = -std::numeric_limits<double>::infinity();
  bool is_running_ = false;
};

template <class Reference>
double ReferenceWindow::filtered(const FeedForwardWeights& weights, double t_s, double cycle_s,
                                 const Reference& reference) {
  if (continues(t_s, cycle_s))
    push(reference(t_s + feed_forward_reach * cycle_s));
  else
    for (int k = -feed_forward_reach; k <= feed_forward_reach; ++k) push(reference(t_s + k * cycle_s));
  last_s_ = t_s;
  filled_ = true;
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * values_[oldest_ + i];
  return sum;
}

template <class Reference>
double PlantInverse::expected(double t_s, double cycle_s, const Reference& reference) {
  const double late_s = t_s - config_.plant.delay_cycles * cycle_s;
  const auto input = [&](int cycles_ago) {
    return late_.filtered(config_.feed_forward, late_s - cycles_ago * cycle_s, cycle_s, reference);
  };
  if (!is_running_) {
    is_running_ = true;
    const int cycles = cycles_since_rest(late_s, cycle_s);
    plant_ = PlantRecursion::at_rest(input(cycles));
    for (int k = cycles - 1; k > 0; --k) PlantRecursion::step(config_.plant, plant_, input(k));
  }
  return PlantRecursion::step(config_.plant, plant_, input(0));
}

}  // namespace hystcan::controller
