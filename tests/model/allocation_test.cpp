// This is a separate program, because its operator new counts allocations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "model/linear_mapping.h"
#include "model/preisach.h"
#include "tests/model/models.h"
#include "tests/support/count_allocations.h"

namespace hystcan::model::allocation_test {
namespace {

TEST(Allocation, IsCountedByTheReplacedOperatorNew) {
  const std::uint64_t before = support::allocations_so_far();
  const HysteresisState state = Hysteresis(piezo_model()).virgin(0.0);
  EXPECT_GT(support::allocations_so_far(), before);
}

template <class Model>
void never_allocates(const Model& model) {
  HysteresisState state = model.virgin(model.input_range().lo, 8);
  const Interval range = model.input_range();
  std::vector<double> walk = nested_swings(range, 40);
  for (const double share : {0.0, 1.0, 0.3, 2.0, -0.05}) walk.push_back(range.lo + share * range.span());
  std::vector<char> text(Model::saved_size(8));
  const std::uint64_t before = support::allocations_so_far();
  double sum = 0.0;
  std::size_t saved = 1;
  for (const double v : walk) {
    sum += model.forward(state, v).value + model.forward(state, range.hi - v).value;
    sum += model.inverse(state, 0.3 * v).value + model.reachable(state, {range.lo, v}).hi;
    sum += model.advance(state, v).value;
    saved = std::min(saved, model.save(state, text).size());
  }
  const std::uint64_t after = support::allocations_so_far();
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
  EXPECT_GT(saved, 0u);
}

TEST(Allocation, NeverHappensInForwardInverseAdvanceOrSave) {
  never_allocates(Hysteresis(piezo_model()));
  never_allocates(Hysteresis(galfenol_model()));
  never_allocates(LinearMapping(piezo_model()));
  never_allocates(Preisach({"V", "um", {0.0, 100.0}, 0.0, 0.1, {1.0, 2.0, 3.0}}));
}

}  // namespace
}  // namespace hystcan::model::allocation_test
