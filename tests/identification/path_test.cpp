#include "identification/path.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identification/regression.h"
#include "tests/identification/rows.h"
#include "tests/model/models.h"

namespace hystcan::identification::path_test {
namespace {

using model::Hysteresis;
using model::HysteresisState;
using model::Origin;

HysteresisState state_at(const Hysteresis& model, Origin origin, double first) {
  if (origin == Origin::virgin) return model.virgin(first);
  return origin == Origin::lower_threshold ? model.at_lower_threshold() : model.at_upper_threshold();
}

Origin any_origin() {
  return *rc::gen::element(Origin::virgin, Origin::lower_threshold, Origin::upper_threshold);
}

TEST(Path, GivesTheSameOutputsAsTheModel) {
  EXPECT_TRUE(rc::check("rows times theta equal advance", [] {
    const Hysteresis model(model::RandomModel::draw());
    const Origin origin = any_origin();
    const std::vector<double> walk = model::random_walk(model.input_range(), 60);
    HysteresisState state = state_at(model, origin, walk[0]);
    const Rows rows(trace(model.input_range(), origin, {}, walk), model.parameters());
    const Eigen::VectorXd theta = theta_of(model.parameters());
    const double span = model.output_range().hi - model.output_range().lo;
    for (std::size_t i = 0; i < walk.size(); ++i)
      RC_ASSERT(std::abs(rows.at(i, walk[i]).dot(theta) - model.advance(state, walk[i]).value) <=
                1e-10 * span);
  }));
}

TEST(Path, StartsANewBranchAtEachThreshold) {
  EXPECT_TRUE(rc::check("for a walk that sometimes goes to both ends", [] {
    const Hysteresis model(model::RandomModel::draw());
    const model::Interval range = model.input_range();
    const Origin origin = any_origin();
    std::vector<double> walk;
    for (int part = 0; part < 4; ++part) {
      const std::vector<double> inside = model::random_walk(range, 12);
      walk.insert(walk.end(), inside.begin(), inside.end());
      walk.push_back(part % 2 == 0 ? range.hi : range.lo);
    }
    HysteresisState state = state_at(model, origin, walk[0]);
    const Path path = trace(range, origin, {}, walk);
    RC_ASSERT(std::ranges::count_if(path.branches, [&](const PathBranch& branch) {
                return branch.parent == PathBranch::none && !branch.virgin;
              }) >= 4);
    const Rows rows(path, model.parameters());
    const Eigen::VectorXd theta = theta_of(model.parameters());
    const double span = model.output_range().hi - model.output_range().lo;
    for (std::size_t i = 0; i < walk.size(); ++i)
      RC_ASSERT(std::abs(rows.at(i, walk[i]).dot(theta) - model.advance(state, walk[i]).value) <=
                1e-10 * span);
  }));
}

TEST(Path, GivesTheSameBranchesForAPrehistoryAsForSamples) {
  EXPECT_TRUE(rc::check("the branches do not depend on whether the beginning is prehistory", [] {
    const model::Interval range{0.0, 10.0};
    const std::vector<double> walk = model::random_walk(range, 40);
    const std::vector<double> before(walk.begin(), walk.begin() + 15), seen(walk.begin() + 15, walk.end());
    const Origin origin = any_origin();
    const Path whole = trace(range, origin, {}, walk), rest = trace(range, origin, before, seen);
    RC_ASSERT(whole.branches.size() == rest.branches.size());
    for (std::size_t i = 0; i < seen.size(); ++i) RC_ASSERT(branch_of(rest, i) == branch_of(whole, i + 15));
  }));
}

TEST(Path, CoversAllSamplesInOrder) {
  const model::Interval range{0.0, 1.0};
  const std::vector<double> walk = model::long_walk(range, 20'000, 5);
  const Path path = trace(range, Origin::lower_threshold, {}, walk);
  std::size_t covered = 0;
  for (const auto& run : path.runs) {
    ASSERT_EQ(run.begin, covered);
    ASSERT_LT(run.begin, run.end);
    ASSERT_LT(run.branch, path.branches.size());
    covered = run.end;
  }
  EXPECT_EQ(covered, walk.size());
}

TEST(BranchRows, GiveTheSlopeOfTheModelsBranch) {
  EXPECT_TRUE(rc::check("slope rows times theta equal the model's derivative", [] {
    const Hysteresis model(model::RandomModel::draw());
    const std::vector<double> walk = model::random_walk(model.input_range(), 30);
    HysteresisState state = model.at_lower_threshold();
    for (const double v : walk) model.advance(state, v);
    const Path path = trace(model.input_range(), Origin::lower_threshold, {}, walk);
    const Rows rows(path, model.parameters());
    const std::size_t last = path.runs.back().branch;
    const PathBranch& branch = path.branches[last];
    const double middle = 0.5 * (walk.back() + branch.target), h = 1e-5 * model.input_range().span();
    RC_PRE(std::abs(branch.target - walk.back()) > 4.0 * h);
    const double rise =
        (model.forward(state, middle + h).value - model.forward(state, middle - h).value) / (2.0 * h);
    const double mean = (model.output_range().hi - model.output_range().lo) / model.input_range().span();
    const double slope = rows.rows.slope(branch, last, middle).dot(theta_of(model.parameters()));
    RC_ASSERT(std::abs(slope - rise) <= 1e-5 * mean);  // h^2 / 6 times the third derivative
  }));
}

}  // namespace
}  // namespace hystcan::identification::path_test
