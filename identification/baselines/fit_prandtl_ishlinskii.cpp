#include "identification/baselines/fit_prandtl_ishlinskii.h"

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "base/text.h"
#include "identification/baselines/baseline_samples.h"
#include "identification/numerics/nonlinear_fit.h"
#include "model/prandtl_ishlinskii.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using model::PlayState;
using model::PrandtlIshlinskii;

// Returns the thresholds of the plays, evenly spaced from zero to half the width of the inputs (both ends
// excluded).
std::vector<double> evenly_spaced(const Samples& samples, std::size_t plays) {
  if (plays < 1) refuse(plays, " plays, expected at least 1");
  const auto [lo, hi] = std::ranges::minmax(samples.input);
  if (!(lo < hi)) refuse("every input is ", lo, ", expected an input that moves");
  std::vector<double> thresholds;
  for (std::size_t i = 1; i <= plays; ++i)
    thresholds.push_back((hi - lo) / 2.0 * static_cast<double>(i) / static_cast<double>(plays + 1));
  return thresholds;
}

// Returns a Prandtl-Ishlinskii operator with weights of zero: only its plays are used.
PrandtlIshlinskii operator_of(std::vector<double> thresholds, const model::Interval& range) {
  std::vector<double> weights(thresholds.size(), 0.0);
  return PrandtlIshlinskii({"", "", range, 0.0, 1.0, std::move(thresholds), std::move(weights)});
}

WeightedOperators fit_plays(const Samples& samples, const std::vector<double>& thresholds,
                            const std::vector<History>& histories) {
  const model::Interval range = widened_range(samples);
  const auto column = [&](std::size_t j, const History& history, const Samples& subset) {
    return run(operator_of({thresholds[j]}, range), history, subset,
               [](const PlayState& state) { return state.plays.front(); });
  };
  return fit_weights(samples, histories, thresholds.size(), column);
}

// A least-squares fit of m plays that also finds the value y_i[0] of each play at the first sample. The model
// and its unknowns are
//
//   x = x_0 + w_0 v + sum_i w_i y_i,     i = 1 .. m        v: input,  x: output,  y_i: play i
//
//   unknowns: x_0, w_0, w_1, ..., w_m, y_1[0], ..., y_m[0]
class FreeStart {
 public:
  FreeStart(const Samples& samples, std::vector<double> thresholds)
      : samples_(samples), thresholds_(std::move(thresholds)), places_(fitted_samples(samples)) {}

  VectorXd start(const WeightedOperators& fit) const {
    const PrandtlIshlinskii plays = operator_of(thresholds_, widened_range(samples_));
    PlayState state = after(plays, fit.history);
    plays.advance(state, samples_.input.front());
    VectorXd x(2 * m() + 2);
    x << fit.offset, fit.gain, numbers(fit.weights), numbers(state.plays);
    return x;
  }

  NonlinearProblem problem() const {
    const auto values = [this](const VectorXd& x) { return std::optional(at(places_, predicted(x))); };
    const auto jacobian = [this](const VectorXd& x) { return jacobian_at(x); };
    const auto [g, h] = inequalities();
    return {values, jacobian, at(places_, samples_.output), at(places_, samples_.weight), g, h};
  }

  std::vector<double> predicted(const VectorXd& x) const {
    std::vector<double> output(samples_.input.size());
    for (std::size_t n = 0; n < output.size(); ++n) output[n] = x[0] + x[1] * samples_.input[n];
    for (Index i = 0; i < m(); ++i) {
      const std::vector<double> plays = play(i, x[2 + m() + i]);
      for (std::size_t n = 0; n < output.size(); ++n) output[n] += x[2 + i] * plays[n];
    }
    return output;
  }

 private:
  Index m() const { return static_cast<Index>(thresholds_.size()); }
  double threshold(Index i) const { return i < 0 ? 0.0 : thresholds_[static_cast<std::size_t>(i)]; }
  static Eigen::Map<const VectorXd> numbers(const std::vector<double>& values) {
    return {values.data(), static_cast<Index>(values.size())};
  }

  std::vector<double> play(Index i, double y) const {
    look(samples_);
    std::vector<double> values;
    values.reserve(samples_.input.size());
    for (const double v : samples_.input)
      values.push_back(y = std::max(v - threshold(i), std::min(v + threshold(i), y)));
    return values;
  }

  // Returns the derivatives of the output by the unknowns. The derivative by an initial play is the weight of
  // the play until the play moves for the first time, and 0 after that.
  MatrixXd jacobian_at(const VectorXd& x) const {
    MatrixXd jacobian(static_cast<Index>(places_.size()), x.size());
    jacobian.col(0).setOnes();
    jacobian.col(1) = at(places_, samples_.input);
    for (Index i = 0; i < m(); ++i) {
      const double y = x[2 + m() + i];
      jacobian.col(2 + i) = at(places_, play(i, y));
      const auto still = (jacobian.col(2 + i).array() == y).cast<double>();
      double moved = 1.0;
      for (Index n = 0; n < jacobian.rows(); ++n) {
        moved *= still[n];
        jacobian(n, 2 + m() + i) = moved * x[2 + i];
      }
    }
    return jacobian;
  }

  // Returns the inequalities that the unknowns must satisfy: the weights w_i are not negative, and the plays
  // y_i at the first sample are possible with the thresholds r_i and the first input v.
  //
  //   w_i >= 0,    |y_i - y_{i-1}| <= r_i - r_{i-1},    y_0 = v,    r_0 = 0
  std::pair<MatrixXd, VectorXd> inequalities() const {
    MatrixXd g = MatrixXd::Zero(1 + 3 * m(), 2 * m() + 2);
    VectorXd h = VectorXd::Zero(g.rows());
    g.block(0, 1, 1 + m(), 1 + m()).setIdentity();
    for (Index i = 0; i < m(); ++i) {
      for (const Index side : {0, 1}) {
        const double sign = side == 0 ? 1.0 : -1.0;
        const Index row = 1 + m() + 2 * i + side, play = 2 + m() + i;
        g(row, play) = sign;
        if (i > 0) g(row, play - 1) = -sign;
        h[row] = (i > 0 ? 0.0 : sign * samples_.input.front()) - (threshold(i) - threshold(i - 1));
      }
    }
    return {g, h};
  }

  const Samples& samples_;
  std::vector<double> thresholds_;
  std::vector<std::size_t> places_;
};

}  // namespace

BaselineModel fit_prandtl_ishlinskii(const Samples& samples, std::size_t plays) {
  check(samples);
  WeightedOperators fit =
      fit_plays(samples, evenly_spaced(samples, plays), histories(samples, widened_range(samples)));
  return {text_of("Prandtl-Ishlinskii, ", plays, " plays"), plays + 2, std::move(fit.prediction)};
}

BaselineModel fit_prandtl_ishlinskii_free_start(const Samples& samples, std::size_t plays) {
  check(samples);
  const std::vector<double> thresholds = evenly_spaced(samples, plays);
  const Samples fitted = reduced(samples);
  const FreeStart model(fitted, thresholds);
  const VectorXd start =
      model.start(fit_plays(fitted, thresholds, histories(samples, widened_range(samples))));
  const Minimum best = improve(model.problem(), start, 40);
  return {text_of("Prandtl-Ishlinskii, ", plays, " plays, free start"), 2 * plays + 2,
          FreeStart(samples, thresholds).predicted(best.x)};
}

}  // namespace hystcan::identification
