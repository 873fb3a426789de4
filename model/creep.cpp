#include "model/creep.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "base/text.h"

namespace hystcan::model {
namespace {

void check(const Creep::Operator& one, std::size_t index) {
  const auto refuse_key = [index](const char* key, double value, const char* expected) {
    refuse("creep operator[", index, "].", key, " = ", value, ", expected ", expected);
  };
  if (!std::isfinite(one.weight)) refuse_key("weight", one.weight, "a finite number");
  if (!std::isfinite(one.rate_per_s) || one.rate_per_s <= 0)
    refuse_key("rate_per_s", one.rate_per_s, "a positive number");
  if (!std::isfinite(one.threshold) || one.threshold < 0)
    refuse_key("threshold", one.threshold, "a number, zero or more");
}

void check(const Creep::Operators& operators, double dt_s) {
  for (std::size_t i = 0; i < operators.size(); ++i) check(operators[i], i);
  if (!std::isfinite(dt_s) || dt_s <= 0) refuse("dt_s = ", dt_s, ", expected a positive number");
}

// Returns the part of `distance` that is outside the dead zone, which extends from -threshold to threshold.
double beyond_dead_zone(double distance, double threshold) {
  return std::max(distance - threshold, std::min(distance + threshold, 0.0));
}

}  // namespace

Creep::Creep(Operators operators, double dt_s) : operators_(std::move(operators)) {
  check(operators_, dt_s);
  shares_.reserve(operators_.size());
  for (const Operator& one : operators_) shares_.push_back(-std::expm1(-one.rate_per_s * dt_s));
}

double Creep::operator()(State& state, double input) const {
  if (!std::isfinite(input)) return output(state);
  for (std::size_t i = 0; i < operators_.size(); ++i)
    state[i] += shares_[i] * beyond_dead_zone(input - state[i], operators_[i].threshold);
  return output(state);
}

double Creep::output(const State& state) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < operators_.size(); ++i) sum += operators_[i].weight * state[i];
  return sum;
}

Creep::Operators logarithmic_creep(double per_decade, double from_s, double to_s) {
  constexpr double spacing = 0.5;  // distance between two time constants, in decades
  if (!std::isfinite(per_decade)) refuse("creep per_decade = ", per_decade, ", expected a finite number");
  if (!std::isfinite(from_s) || from_s <= 0)
    refuse("creep from_s = ", from_s, ", expected a positive number");
  if (!std::isfinite(to_s) || to_s <= from_s)
    refuse("creep to_s = ", to_s, ", expected more than from_s = ", from_s);
  const double decades = std::log10(to_s) - std::log10(from_s);
  const int last = static_cast<int>(std::ceil((decades + 2.0) / spacing - 1e-9));
  Creep::Operators operators;
  operators.reserve(static_cast<std::size_t>(last) + 2);
  for (int i = -1; i <= last; ++i)
    operators.push_back({per_decade * spacing, std::pow(10.0, -spacing * i) / from_s, 0.0});
  return operators;
}

}  // namespace hystcan::model
