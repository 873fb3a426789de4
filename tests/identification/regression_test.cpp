#include "identification/regression.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "identification/excerpt.h"
#include "identification/separable_fit.h"
#include "tests/identification/rows.h"
#include "tests/model/models.h"

namespace hystcan::identification::regression_test {
namespace {

constexpr model::Interval range{-2.0, 3.0};
constexpr int order = 6;
constexpr Pace pace{0.8, -0.3};
const CurveBasis basis(CurveShape::polynomial(order), range);

struct Case {
  std::vector<double> input = model::long_walk(range, 400, 3);
  std::vector<double> output;
  std::vector<int> fold;
  Path path = trace(range, model::Origin::upper_threshold, {}, input);

  explicit Case(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> any;
    for (std::size_t i = 0; i < input.size(); ++i) {
      output.push_back(any(random));
      fold.push_back(static_cast<int>(random() % 4) - 1);  // Regression::left_out, 0, 1, 2
    }
  }
  Regression of(const std::vector<int>& parts) const {
    return {path, basis, {.input = input, .output = output, .fold = parts}, 3};
  }
  std::vector<NormalEquations> summed(const Pace& at) const {
    const Regression regression = of(fold);
    std::vector<NormalEquations> folds(3, NormalEquations(regression.unknowns()));
    regression.add(at, folds);
    return folds;
  }
  NormalEquations row_by_row(int part, const Pace& at) const {
    NormalEquations sum(2 * order + 1);
    const Rows rows(path, basis, at);
    for (std::size_t i = 0; i < input.size(); ++i) {
      if (fold[i] != part) continue;
      const Eigen::VectorXd row = rows.at(i, input[i]);
      sum.H += row * row.transpose();
      sum.g += output[i] * row;
      sum.square += output[i] * output[i];
      sum.samples += 1.0;
    }
    return sum;
  }
};

void expect_same(const NormalEquations& a, const NormalEquations& b) {
  EXPECT_LE((a.H - b.H).norm(), 1e-11 * b.H.norm());  // rounding over some hundred samples
  EXPECT_LE((a.g - b.g).norm(), 1e-11 * b.H.norm());
  EXPECT_NEAR(a.square, b.square, 1e-11 * b.square);
  EXPECT_EQ(a.samples, b.samples);
}

TEST(Regression, SumsTheRowsOfItsSamples) {
  const Case made(1);
  for (const Pace& at : {pace, Pace{0.0, 0.0}, Pace{10.0, 40.0}, Pace{-1.5, 2.0}}) {
    const std::vector<NormalEquations> folds = made.summed(at);
    for (int part = 0; part < 3; ++part)
      expect_same(folds[static_cast<std::size_t>(part)], made.row_by_row(part, at));
  }
}

TEST(Regression, WeighsTheRowsOfItsSamplesButNotTheNuisances) {
  const Case made(4);
  std::vector<double> weight;
  std::vector<std::vector<double>> column(1);
  for (std::size_t i = 0; i < made.input.size(); ++i) {
    weight.push_back(0.1 + static_cast<double>(i % 7));
    column[0].push_back(std::sin(static_cast<double>(i)));
  }
  const Regression regression(
      made.path, basis,
      {.input = made.input, .output = made.output, .weight = weight, .fold = made.fold, .regressors = column},
      3, {.offset = true});
  std::vector<NormalEquations> folds(3, NormalEquations(regression.unknowns()));
  regression.add(pace, folds);
  NormalEquations expected(2 * order + 3);
  const Rows rows(made.path, basis, pace);
  for (std::size_t i = 0; i < made.input.size(); ++i) {
    if (made.fold[i] != 1) continue;
    Eigen::VectorXd row(expected.g.size());
    row << weight[i] * rows.at(i, made.input[i]), column[0][i], 1.0;
    expected.H += row * row.transpose();
    expected.g += weight[i] * made.output[i] * row;
    expected.square += weight[i] * made.output[i] * weight[i] * made.output[i];
    expected.samples += 1.0;
  }
  expect_same(folds[1], expected);
}

TEST(Regression, SumOfTheFoldsEqualsTheWhole) {
  const Case made(2);
  Case whole = made;
  for (int& part : whole.fold) part = std::min(part, 0);
  NormalEquations sum(2 * order + 1);
  for (const NormalEquations& fold : made.summed(pace)) sum += fold;
  expect_same(sum, whole.summed(pace)[0]);
  sum.take_away(made.summed(pace)[2], 1.0);
  NormalEquations without = made.row_by_row(0, pace);
  expect_same(sum, without += made.row_by_row(1, pace));
}

TEST(Regression, IgnoresTheOutputOfALeftOutSample) {
  const Case made(3);
  Case spoilt = made;
  for (std::size_t i = 0; i < spoilt.output.size(); ++i)
    if (spoilt.fold[i] == Regression::left_out) spoilt.output[i] = 1e9;
  const auto a = made.summed(pace), b = spoilt.summed(pace);
  for (std::size_t part = 0; part < 3; ++part) {
    EXPECT_EQ(a[part].H, b[part].H);
    EXPECT_EQ(a[part].g, b[part].g);
    EXPECT_EQ(a[part].square, b[part].square);
  }
}

TEST(Regression, AddsToTheSumsOfAnotherDataset) {
  const Case made(4);
  const Regression regression = made.of(made.fold);
  std::vector<NormalEquations> twice = made.summed(pace);
  regression.add(pace, twice);
  NormalEquations once = made.summed(pace)[1];
  expect_same(twice[1], once += made.summed(pace)[1]);
}

TEST(NormalEquations, GiveTheSumOfSquaresForEveryTheta) {
  const Case made(5);
  const NormalEquations system = made.summed(pace)[0];
  const Rows rows(made.path, basis, pace);
  const Eigen::VectorXd theta = Eigen::VectorXd::LinSpaced(2 * order + 1, -1.0, 2.0);
  double square = 0.0;
  for (std::size_t i = 0; i < made.input.size(); ++i)
    if (made.fold[i] == 0) square += std::pow(rows.at(i, made.input[i]).dot(theta) - made.output[i], 2);
  EXPECT_NEAR(system.residual_square(theta), square, 1e-10 * square);
}

TEST(Excerpt, RemovesCreepFromFewSamplesAsFromAll) {
  Dataset dataset;
  for (int i = 0; i < 3000; ++i) {
    dataset.time_s.push_back(1e-3 * i);
    dataset.input.push_back(50.0 - 50.0 * std::cos(0.02 * i));
    dataset.output.push_back(0.3 * dataset.input.back() + std::sin(0.001 * i));
  }
  const model::OutputCreep creep(creep_of(0.043));
  const Dataset all = Excerpt(dataset, {}, dataset.size(), 1.0).delayed_by(0.0, creep);
  const Dataset few = Excerpt(dataset, {}, dataset.size() / 10, 1.0).delayed_by(0.0, creep);
  double largest = 0.0;
  std::size_t compared = 0;
  for (std::size_t i = 0, j = 0; j < few.size(); ++j) {
    if (few.fold[j] == Regression::left_out) continue;
    while (all.fold[i] == Regression::left_out || all.time_s[i] < few.time_s[j]) ++i;
    largest = std::max(largest, std::abs(few.output[j] - all.output[i]));
    ++compared;
  }
  EXPECT_EQ(compared, dataset.size() / 10);
  EXPECT_LT(largest, 3e-8);  // um of 30: a billionth
}

}  // namespace
}  // namespace hystcan::identification::regression_test
