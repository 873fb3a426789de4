#include "model/dynamics.h"

#include "base/text.h"

namespace hystcan::model {
namespace {

double checked(double delay_s) {
  if (!(delay_s >= 0.0)) refuse("delay_s = ", delay_s, ", expected 0 or more");
  return delay_s;
}

}  // namespace

DynamicOutput::DynamicOutput(const Dynamics& dynamics, double cycle_s, double first)
    : mode_(dynamics.mode, checked(dynamics.delay_s), cycle_s),
      state_(first, 0.0),
      past_(static_cast<std::size_t>(mode_.whole_cycles()) + 2, first) {}

double DynamicOutput::advance(double quasi_static) {
  const std::size_t next = oldest_ + 1 == past_.size() ? 0 : oldest_ + 1;
  state_ = mode_.step(state_, past_[oldest_], past_[next]);
  past_[oldest_] = quasi_static;
  oldest_ = next;
  return state_[0];
}

}  // namespace hystcan::model
