#include "identification/baselines/fit_linear_mapping.h"

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "identification/baselines/baseline_samples.h"
#include "identification/numerics/nonlinear_fit.h"
#include "model/linear_mapping.h"

namespace hystcan::identification {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using model::Direction;
using model::HysteresisParameters;
using model::HysteresisState;
using model::LinearMapping;
using model::ReferenceCurve;

// The two reference curves as functions of the unknowns of the fit. The unknowns are all coefficients a_i of
// f^A, and all coefficients d_i of f^D except one. The remaining coefficient follows from the condition that
// the curves meet at the upper threshold v_hi, with the basis functions B_i:
//
//   sum a_i B_i(v_hi) = sum d_i B_i(v_hi)
class Curves {
 public:
  explicit Curves(const HysteresisParameters& start)
      : start_(start), up_(ends(start.ascending)), down_(ends(start.descending)) {
    down_.cwiseAbs().maxCoeff(&closing_);
  }

  Index unknowns() const { return up_.size() + down_.size() - 1; }

  VectorXd coefficients() const {
    const std::vector<double>& a = start_.ascending.coefficients();
    std::vector<double> d = start_.descending.coefficients();
    d.erase(d.begin() + closing_);
    VectorXd x(unknowns());
    for (Index j = 0; j < x.size(); ++j)
      x[j] = j < up_.size() ? a[static_cast<std::size_t>(j)] : d[static_cast<std::size_t>(j - up_.size())];
    return x;
  }

  HysteresisParameters parameters(const VectorXd& x) const {
    HysteresisParameters p = start_;
    const VectorXd a = x.head(up_.size());
    std::vector<double> d(x.begin() + up_.size(), x.end());
    d.insert(d.begin() + closing_, 0.0);
    const double open = up_.dot(a) - down_.dot(Eigen::Map<const VectorXd>(d.data(), down_.size()));
    d[static_cast<std::size_t>(closing_)] = open / down_[closing_];
    p.ascending = start_.ascending.with({a.begin(), a.end()});
    p.descending = start_.descending.with(d);
    return p;
  }

  /// Returns the coefficients of a number that is linear in the unknowns of the fit. `read` computes this
  /// number from the curve of `direction`, for example its slope at an input. Element j of the result is the
  /// number for the curve with unknown j = 1 and all other unknowns 0.
  template <class Read>
  VectorXd row(Direction direction, Read read) const {
    VectorXd row(unknowns());
    for (Index j = 0; j < row.size(); ++j)
      row[j] = read(parameters(VectorXd::Unit(row.size(), j)).curve(direction));
    return row;
  }

 private:
  // Returns the values of the curve's basis functions at the upper threshold.
  static VectorXd ends(const ReferenceCurve& curve) {
    const std::size_t count = curve.coefficients().size();
    VectorXd ends(static_cast<Index>(count));
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<double> unit(count, 0.0);
      unit[i] = 1.0;
      ends[static_cast<Index>(i)] = curve.with(unit).value(curve.domain().hi);
    }
    return ends;
  }

  HysteresisParameters start_;
  VectorXd up_, down_;
  Index closing_ = 0;
};

// Returns inequalities G x >= h for the unknowns of the curves, on a grid. Both curves rise with at least a
// thousandth of their mean slope. The descending curve is above the ascending curve, and approaches it from
// above at the upper threshold.
std::pair<MatrixXd, VectorXd> inequalities(const Curves& curves, const HysteresisParameters& start) {
  constexpr Index points = 200;
  const model::Interval range = start.input_range();
  const double rise = start.upper_point().level - start.lower_point().level;
  MatrixXd g(3 * (points + 1), curves.unknowns());
  VectorXd h = VectorXd::Constant(g.rows(), 1e-3 * rise / range.span());
  for (Index i = 0; i <= points; ++i) {
    const double v = range.lo + range.span() * static_cast<double>(i) / points;
    const auto slope = [v](const ReferenceCurve& curve) { return curve.slope(v); };
    const auto value = [v](const ReferenceCurve& curve) { return curve.value(v); };
    const VectorXd up = curves.row(Direction::ascending, slope);
    const VectorXd down = curves.row(Direction::descending, slope);
    g.row(3 * i) = up.transpose();
    g.row(3 * i + 1) = down.transpose();
    g.row(3 * i + 2) =
        i == points ? (up - down).transpose()
                    : (curves.row(Direction::descending, value) - curves.row(Direction::ascending, value))
                          .transpose();
    h[3 * i + 2] = 0.0;
  }
  return {g, h};
}

// The nonlinear least-squares problem that finds the coefficients of the curves. The model gets the inputs in
// `history` before the first sample.
class Mapping {
 public:
  Mapping(const Samples& samples, const HysteresisParameters& start, History history)
      : samples_(samples), curves_(start), history_(std::move(history)), places_(fitted_samples(samples)) {}

  std::vector<double> predicted(const VectorXd& x) const {
    return run(LinearMapping(curves_.parameters(x)), history_, samples_,
               [](const HysteresisState& state) { return state.output; });
  }

  NonlinearProblem problem(const std::pair<MatrixXd, VectorXd>& limits) const {
    return {[this](const VectorXd& x) { return values(x); },
            [this](const VectorXd& x) { return jacobian(x); },
            at(places_, samples_.output),
            at(places_, samples_.weight),
            limits.first,
            limits.second};
  }

 private:
  std::optional<VectorXd> values(const VectorXd& x) const {
    try {
      return at(places_, predicted(x));
    } catch (const std::invalid_argument&) {  // the curves are not valid
      return std::nullopt;
    }
  }

  // Returns the derivatives of the values by each unknown, as differences. If the curves are not valid after
  // an increase of the unknown, decreases it instead.
  MatrixXd jacobian(const VectorXd& x) const {
    const VectorXd here = *values(x);
    const double step = 1e-6 * x.cwiseAbs().maxCoeff();
    MatrixXd result = MatrixXd::Zero(here.size(), x.size());
    for (Index j = 0; j < x.size(); ++j) {
      for (const double change : {step, -step}) {
        const auto there = values(x + change * VectorXd::Unit(x.size(), j));
        if (!there) continue;
        result.col(j) = (*there - here) / change;
        break;
      }
    }
    return result;
  }

  const Samples& samples_;
  Curves curves_;
  History history_;
  std::vector<std::size_t> places_;
};

}  // namespace

BaselineModel fit_linear_mapping(const Samples& samples, const HysteresisParameters& start) {
  check(samples);
  const LinearMapping checked(start);
  Samples seen = samples;
  seen.range = start.input_range();
  if (start.symmetry == model::Symmetry::even)
    for (auto* inputs : {&seen.input, &seen.prehistory})
      for (double& v : *inputs) v = std::abs(v);
  const Curves curves(start);
  const auto limits = inequalities(curves, start);
  double least = std::numeric_limits<double>::infinity();
  BaselineModel baseline{"linear mapping", static_cast<std::size_t>(curves.unknowns()), {}};
  const Samples fitted = reduced(seen);
  for (const History& history : histories(seen, start.input_range())) {
    const Mapping mapping(fitted, start, history);
    const Minimum fit = improve(mapping.problem(limits), curves.coefficients(), 15);
    if (!(fit.value < least)) continue;
    least = fit.value;
    baseline.prediction = Mapping(seen, start, history).predicted(fit.x);
  }
  return baseline;
}

}  // namespace hystcan::identification
