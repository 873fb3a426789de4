#include "identification/dynamics/joint_dynamics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/text.h"
#include "identification/dynamics/sampled_dataset.h"
#include "identification/dynamics/second_order_fit.h"
#include "identification/numerics/nonlinear_fit.h"
#include "identification/quasi_static.h"

namespace hystcan::identification {
namespace {

using model::Dynamics;

constexpr int most_passes = 8;
// Number of first passes that also select the shape of the reference curves; later passes keep the shape. A
// pass identifies the quasi-static model again, and then fits the dynamics.
constexpr int passes_with_shape = 2;
constexpr int steps_in_a_pass = 10;
// A pass identifies the quasi-static model again, and then fits the dynamics. Another pass follows if the
// error after a pass is below this share of the error before it.
constexpr double worth_a_pass = 0.995;
// Dynamics are refused if their error is above this share of the quasi-static error.
constexpr double worth_dynamics = 0.97;
constexpr std::size_t rows_for_the_start = 20'000;
constexpr Eigen::Index dynamics_unknowns = 3;

using Outputs = std::vector<std::vector<double>>;  // for each dataset, an output at each sample

/// Returns the part of the dataset in which the input moves most: as many consecutive rows as
/// rows_for_the_start.
Dataset fastest_part(const Dataset& dataset) {
  if (dataset.size() <= rows_for_the_start) return dataset;
  std::vector<double> travel(dataset.size(), 0.0);
  for (std::size_t i = 1; i < travel.size(); ++i)
    travel[i] = travel[i - 1] + std::abs(dataset.input[i] - dataset.input[i - 1]);
  std::size_t first = 0;
  for (std::size_t i = 0; i + rows_for_the_start < travel.size(); i += rows_for_the_start / 10)
    if (travel[i + rows_for_the_start - 1] - travel[i] >
        travel[first + rows_for_the_start - 1] - travel[first])
      first = i;
  const auto part = [&](const std::vector<double>& column) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(first);
    return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(rows_for_the_start));
  };
  return {dataset.input_unit, dataset.output_unit, part(dataset.time_s), part(dataset.input),
          part(dataset.output)};
}

double cycle_s_of(const std::vector<Dataset>& datasets, std::size_t i) {
  try {
    return grid_of(datasets[i].time_s).cycle_s;
  } catch (const std::invalid_argument& error) {
    refuse("dataset ", i + 1, ": ", error.what());
  }
}

class JointDynamics {
 public:
  JointDynamics(const std::vector<Dataset>& datasets, const IdentifyOptions& options)
      : datasets_(datasets), options_(options) {
    if (!options_.go_on) options_.go_on = [] { return true; };
    for (std::size_t i = 0; i < datasets_.size(); ++i) {
      cycle_s_ = std::min(cycle_s_, cycle_s_of(datasets_, i));
      longest_s_ = std::max(longest_s_, datasets_[i].time_s.back() - datasets_[i].time_s.front());
    }
  }

  Identified run() {
    Identified before = identify(datasets_, options_);
    if (!options_.go_on()) return before;
    begin(before);
    Identified best = with_dynamics(before);
    IdentifyOptions options = options_;
    options.delay_s = 0.0;
    options.longest_delay_s.reset();
    for (int pass = 0; pass < most_passes && options_.go_on(); ++pass) {
      if (pass >= passes_with_shape) options.shape = best.search.shape;
      Identified next = with_dynamics(identify(linearised_at(best), options));
      const bool is_worth_another = next.overall.rms < worth_a_pass * best.overall.rms;
      if (next.overall.rms < best.overall.rms) best = std::move(next);
      if (!is_worth_another) break;
    }
    best.stopped = best.stopped || !options_.go_on();
    return compared(before, std::move(best));
  }

 private:
  /// Returns the datasets of the quasi-static output. Their regressors are the effects of small changes of
  /// frequency, damping and delay.
  std::vector<Dataset> linearised_at(const Identified& found) {
    std::vector<Dataset> linear = without_dynamics(datasets_, found, outputs_);
    for (int p = 0; p < point_.size(); ++p) {
      double largest = 0.0;
      for (std::size_t i = 0; i < linear.size(); ++i) {
        linear[i].regressors.push_back(before_dynamics(*found.dynamics, linear[i].time_s, slope(i, p)));
        for (const double value : linear[i].regressors.back()) largest = std::max(largest, std::abs(value));
      }
      if (largest == 0.0) continue;
      for (Dataset& dataset : linear)
        for (double& value : dataset.regressors.back()) value /= largest;
    }
    return linear;
  }

  /// Returns the model `found` with the dynamics that fit it best: frequency, damping and delay.
  Identified with_dynamics(Identified found) {
    outputs_ = quasi_static_outputs(datasets_, found);
    improve_dynamics(found);
    found.dynamics = dynamics_at(point_);
    found.delay_s = 0.0;
    judge(found, datasets_);
    return found;
  }

  /// Sets the first dynamics: the mode of the dataset that shows a mode most clearly. In this dataset, the
  /// natural frequency has the narrowest confidence interval.
  void begin(const Identified& before) {
    outputs_ = quasi_static_outputs(datasets_, before);
    std::optional<SecondOrderFit> clearest;
    std::string reason;
    const auto width = [](const SecondOrderFit& fit) {
      return std::log(fit.natural_frequency_Hz.hi / fit.natural_frequency_Hz.lo);
    };
    for (std::size_t i = 0; i < datasets_.size() && options_.go_on(); ++i) {
      Dataset driven = datasets_[i];
      driven.input = outputs_[i];
      try {
        const SecondOrderFit fit = fit_second_order(fastest_part(driven));
        if (!clearest || width(fit) < width(*clearest)) clearest = fit;
      } catch (const std::invalid_argument& error) {
        reason += text_of(reason.empty() ? "" : "; ", "dataset ", i + 1, ": ", error.what());
      }
    }
    if (!clearest) refuse("no dataset shows a mode: ", reason);
    point_ = {std::log(clearest->natural_frequency_Hz.value), std::log(clearest->damping_ratio.value),
              clearest->delay_s.value / cycle_s_};
    point_ = point_.cwiseMax(lowest()).cwiseMin(highest());
  }

  Dynamics dynamics_at(const Eigen::Vector3d& point) const {
    return {{std::exp(point[0]), std::exp(point[1])}, std::max(0.0, point[2] * cycle_s_)};
  }
  Eigen::Vector3d lowest() const {
    return {std::log(0.3 / longest_s_), std::log(1e-4), options_.delay_s.value_or(0.0) / cycle_s_};
  }
  Eigen::Vector3d highest() const {
    const double longest_s = options_.longest_delay_s.value_or(largest_delay_cycles * cycle_s_);
    return {std::log(largest_frequency_cycles / cycle_s_), std::log(5.0),
            options_.delay_s.value_or(longest_s) / cycle_s_};
  }

  /// Returns the derivative of the response of dataset i by one parameter of the dynamics, p, by differences.
  std::vector<double> slope(std::size_t i, int p) const {
    constexpr double h = 1e-4;
    Eigen::Vector3d more = point_, less = point_;
    more[p] += h;
    less[p] -= h;
    if (p == 2) less[p] = std::max(less[p], 0.0);
    std::vector<double> slope = respond(dynamics_at(more), datasets_[i].time_s, outputs_[i]);
    const std::vector<double> below = respond(dynamics_at(less), datasets_[i].time_s, outputs_[i]);
    for (std::size_t row = 0; row < slope.size(); ++row)
      slope[row] = (slope[row] - below[row]) / (more[p] - less[p]);
    return slope;
  }

  template <class Column>
  void all_rows(Column column, const std::function<std::vector<double>(std::size_t)>& of) const {
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < datasets_.size(); ++i)
      for (const double value : of(i)) column[at++] = value;
  }

  /// Fits frequency, damping and delay to the measured outputs, for the present quasi-static outputs.
  void improve_dynamics(const Identified& found) {
    Eigen::Index rows = 0;
    for (const Dataset& dataset : datasets_) rows += static_cast<Eigen::Index>(dataset.size());
    NonlinearProblem problem;
    problem.wanted.resize(rows);
    problem.weight.setOnes(rows);
    all_rows(Eigen::Ref<Eigen::VectorXd>(problem.wanted), [&](std::size_t i) {
      std::vector<double> wanted = datasets_[i].output;
      for (std::size_t row = 0; row < wanted.size(); ++row)
        wanted[row] = (wanted[row] - found.zero_at(i, datasets_[i].time_s, row)) / found.gains[i];
      return wanted;
    });
    if (!options_.unseen.empty())
      all_rows(Eigen::Ref<Eigen::VectorXd>(problem.weight), [&](std::size_t i) {
        std::vector<double> weight;
        for (const bool unseen : options_.unseen[i]) weight.push_back(unseen ? 0.0 : 1.0);
        return weight;
      });
    problem.values = [&](const Eigen::VectorXd& at) -> std::optional<Eigen::VectorXd> {
      if (!options_.go_on()) return Eigen::VectorXd::Constant(rows, 1e150);  // a huge error ends the fit
      Eigen::VectorXd values(rows);
      all_rows(Eigen::Ref<Eigen::VectorXd>(values),
               [&](std::size_t i) { return respond(dynamics_at(at), datasets_[i].time_s, outputs_[i]); });
      return values;
    };
    problem.jacobian = [&](const Eigen::VectorXd& at) {
      point_ = at;
      Eigen::MatrixXd jacobian(rows, dynamics_unknowns);
      for (int p = 0; p < jacobian.cols(); ++p)
        all_rows(jacobian.col(p), [&](std::size_t i) { return slope(i, p); });
      return jacobian;
    };
    problem.g.resize(2 * dynamics_unknowns, dynamics_unknowns);
    problem.g << Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity();
    problem.h.resize(2 * dynamics_unknowns);
    problem.h << lowest(), -highest();
    point_ = improve(problem, point_, steps_in_a_pass).x;
  }

  Identified compared(const Identified& before, Identified best) const {
    if (best.overall.rms > worth_dynamics * before.overall.rms)
      refuse("a mode at ", std::round(best.dynamics->mode.natural_frequency_Hz),
             " Hz lowers the RMS error by less than ", std::round(100.0 * (1.0 - worth_dynamics)),
             " %; without the mode, the error is ", before.overall.rms, " ", best.parameters.output_unit,
             ": use faster inputs to show the dynamics");
    for (std::size_t i = 0; i < datasets_.size(); ++i)
      best.datasets[i] = characterise(datasets_[i], best.observed);
    best.output_span = before.output_span;
    best.search.steps.insert(best.search.steps.begin(), {{Quantity::Kind::mode},
                                                         before.overall.rms,
                                                         best.overall.rms,
                                                         before.held_out_rms,
                                                         best.held_out_rms});
    return best;
  }

  const std::vector<Dataset>& datasets_;
  IdentifyOptions options_;
  Eigen::Vector3d point_;  // log of the frequency, log of the damping ratio, delay in cycles
  double cycle_s_ = std::numeric_limits<double>::infinity();
  double longest_s_ = 0.0;
  Outputs outputs_;  // quasi-static output x of each dataset
};

}  // namespace

Identified identify_dynamics(const std::vector<Dataset>& datasets, const IdentifyOptions& options) {
  return JointDynamics(datasets, options).run();
}

}  // namespace hystcan::identification
