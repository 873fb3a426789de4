// A program of its own: its operator new counts.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <new>

#include "tests/model/models.h"

namespace {
std::size_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace hystcan::model {
namespace {

TEST(Allocation, IsCounted) {
  const std::size_t before = allocations;
  const HysteresisState state = Hysteresis(piezo_model()).virgin(0.0);
  EXPECT_GT(allocations, before);
}

TEST(Allocation, NeverHappensInForwardInverseOrAdvance) {
  const Hysteresis model(piezo_model());
  HysteresisState state = HysteresisState(model.virgin(0.0, 8));
  const auto walk = nested_swings(model.input_range(), 40);
  const std::size_t before = allocations;
  double sum = 0.0;
  for (const double v : walk) {
    sum += model.forward(state, v).value + model.forward(state, 100.0 - v).value;
    sum += model.inverse(state, 0.3 * v).value;
    sum += model.advance(state, v).value;
  }
  for (const double v : {0.0, 100.0, 30.0, 200.0, -5.0}) sum += model.advance(state, v).value;
  const std::size_t after = allocations;
  EXPECT_EQ(after, before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace hystcan::model
