#include "identification/valid_curves.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "model/hysteresis.h"
#include "tests/identification/made_record.h"
#include "tests/identification/rows.h"
#include "tests/model/models.h"

namespace hystcan::identification::valid_curves_test {
namespace {

using model::Hysteresis;
using model::Origin;

NormalEquations system_of(const Dataset& dataset, model::Interval thresholds, const CurveShape& shape,
                          const Pace& pace) {
  Dataset samples = dataset;
  samples.fold.assign(dataset.size(), 0);
  const Regression regression(trace(thresholds, Origin::lower_threshold, {}, dataset.input),
                              CurveBasis(shape, thresholds), samples, 1);
  std::vector<NormalEquations> systems(1, NormalEquations(regression.unknowns()));
  regression.add(pace, systems);
  return systems.front();
}

// Roughly monotone, with a loop and noise. Valid models rarely give such a dataset.
Dataset random_dataset(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> normal;
  const model::Interval range{-1.0, 4.0};
  Dataset dataset{"V", "um", {}, model::long_walk(range, 300, random()), {}};
  const double bend = share(random), width = 0.5 * share(random), noise = 0.2 * std::pow(share(random), 3.0);
  double lag = 0.0, before = dataset.input.front();
  for (std::size_t i = 0; i < dataset.input.size(); ++i) {
    const double t = (dataset.input[i] - range.lo) / range.span();
    lag = std::clamp(lag + (dataset.input[i] - before) / range.span(), -width, width);
    before = dataset.input[i];
    dataset.time_s.push_back(static_cast<double>(i));
    dataset.output.push_back(10.0 * ((1.0 - bend) * t + bend * t * t * t - lag + noise * normal(random)));
  }
  return dataset;
}

TEST(ValidCurves, AlwaysGiveAValidModel) {
  std::mt19937_64 random(20);
  int bent = 0;
  for (int order = 1; order <= 10; ++order) {
    const CurveShape shape = CurveShape::polynomial(order);
    ValidCurves curves(shape, 200);  // the resolution of the check of a loaded model
    for (const double k : {-3.0, 0.0, 0.5, 2.0, 8.0, 20.0, 50.0}) {
      const Dataset dataset = random_dataset(random);
      const model::Interval range{-1.0, 4.0};
      const Pace pace{k / range.span(), (random() % 2 == 0 ? k : 0.3 * k) / range.span()};
      const NormalEquations system = system_of(dataset, range, shape, pace);
      const ValidCurves::Solution solution = curves.solve(system, range, pace, 10.0, range.span());
      ASSERT_TRUE(solution.valid) << "order " << order << ", k " << k << ", violation " << solution.violation;
      EXPECT_NO_THROW(Hysteresis(curves.basis().parameters(solution.theta, pace)))
          << "order " << order << ", k " << k;
      const Eigen::VectorXd free = system.H.completeOrthogonalDecomposition().solve(system.g);
      bent += system.residual_square(solution.theta) > 1.0001 * system.residual_square(free) ? 1 : 0;
    }
  }
  EXPECT_GE(bent, 35);  // of 70: the bounds are active in at least half of the cases
}

TEST(ValidCurves, GiveValidSplines) {
  std::mt19937_64 random(21);
  for (const std::vector<double>& knots :
       {std::vector<double>{-1.0, 4.0}, {-1.0, 1.0, 1.1, 1.2, 4.0}, {-0.5, 0.0, 1.0, 3.0}}) {
    const CurveShape shape = CurveShape::spline(knots);
    ValidCurves curves(shape, 200);
    for (const double k : {-3.0, 0.0, 2.0, 20.0}) {
      const Dataset dataset = random_dataset(random);
      const model::Interval range{-1.0, 4.0};
      const Pace pace{k / range.span(), k / range.span()};
      const ValidCurves::Solution solution =
          curves.solve(system_of(dataset, range, shape, pace), range, pace, 10.0, range.span());
      ASSERT_TRUE(solution.valid) << shape.text() << ", k " << k << ", violation " << solution.violation;
      EXPECT_NO_THROW(Hysteresis(curves.basis().parameters(solution.theta, pace)));
    }
  }
}

TEST(ValidCurves, KeepTheBestSolutionIfItIsValid) {
  for (const auto& truth : {model::piezo_model(), model::galfenol_model()}) {
    const Hysteresis model(truth);
    const CurveShape shape = CurveShape::polynomial((static_cast<int>(theta_of(truth).size()) - 1) / 2);
    const Dataset dataset = record_of(model, 100.0);
    const Pace pace{truth.k_ascending, truth.k_descending};
    const NormalEquations system = system_of(dataset, truth.input_range(), shape, pace);
    const double output_span = model.output_range().hi - model.output_range().lo;
    ValidCurves curves(shape, 200);
    const auto solution =
        curves.solve(system, truth.input_range(), pace, output_span, truth.input_range().span());
    ASSERT_TRUE(solution.valid);
    const double rms = std::sqrt(system.residual_square(solution.theta) / system.samples);
    EXPECT_LT(rms, 1e-6 * output_span);  // normal equations square the rounding
    EXPECT_LT((solution.theta - theta_of(truth)).norm(), 1e-3 * output_span);  // caused by the regularisation
  }
}

TEST(ValidCurves, ReportAViolationOfZeroOnlyIfTheSolutionIsValid) {
  std::mt19937_64 random(7);
  const CurveShape shape = CurveShape::polynomial(3);
  ValidCurves curves(shape, 50);
  const Dataset dataset = random_dataset(random);
  const Pace pace{1e4, 1e4};  // far beyond the limit of any loop with some width
  const NormalEquations system = system_of(dataset, {-1.0, 4.0}, shape, pace);
  const auto solution = curves.solve(system, {-1.0, 4.0}, pace, 10.0, 5.0);
  EXPECT_EQ(solution.valid, solution.violation == 0.0);
  EXPECT_TRUE(solution.theta.allFinite());
}

}  // namespace
}  // namespace hystcan::identification::valid_curves_test
