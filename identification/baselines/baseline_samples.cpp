#include "identification/baselines/baseline_samples.h"

#include <cmath>

#include "base/text.h"

namespace hystcan::identification {
namespace {

void check_column(const char* name, std::span<const double> values, std::size_t size) {
  if (values.size() != size) refuse(values.size(), " values of ", name, ", expected ", size);
  for (std::size_t n = 0; n < values.size(); ++n)
    if (!std::isfinite(values[n])) refuse(name, " ", n, " is ", values[n], ", expected a finite number");
}

}  // namespace

void check(const Samples& samples) {
  check_column("prehistory", samples.prehistory, samples.prehistory.size());
  check_column("input", samples.input, samples.input.size());
  check_column("output", samples.output, samples.input.size());
  check_column("weight", samples.weight, samples.input.size());
  for (const double weight : samples.weight)
    if (weight < 0.0) refuse("weight is ", weight, ", expected a number >= 0");
  if (std::ranges::none_of(samples.weight, [](double weight) { return weight > 0.0; }))
    refuse("no weight is positive, expected some samples to fit to");
  const model::Interval& range = samples.range;
  if (!std::isfinite(range.lo) || !std::isfinite(range.span()) || !(range.lo < range.hi))
    refuse("range [", range.lo, ", ", range.hi, "], expected finite lo < hi");
}

void look(const Samples& samples) {
  if (samples.go_on && !samples.go_on()) throw Stopped();
}

std::vector<std::size_t> fitted_samples(const Samples& samples) {
  constexpr std::size_t enough = 5000;
  std::vector<std::size_t> weighted;
  for (std::size_t n = 0; n < samples.weight.size(); ++n)
    if (samples.weight[n] > 0.0) weighted.push_back(n);
  const std::size_t count = std::min(enough, weighted.size());
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(weighted[i * weighted.size() / count]);
  return some;
}

ReducedSamples::ReducedSamples(const Samples& samples)
    : prehistory_(samples.prehistory), range_(samples.range), go_on_(samples.go_on) {
  const std::span<const double> v = samples.input;
  const auto turns = [&](std::size_t n) { return (v[n] - v[n - 1]) * (v[n + 1] - v[n]) <= 0.0; };
  std::vector<bool> kept(v.size(), false);
  for (const std::size_t n : fitted_samples(samples)) kept[n] = true;
  for (std::size_t n = 0; n < v.size(); ++n) {
    const bool fitted = kept[n];
    if (!fitted && n > 0 && (n + 1 == v.size() || !turns(n))) continue;
    input_.push_back(v[n]);
    output_.push_back(samples.output[n]);
    weight_.push_back(fitted ? samples.weight[n] : 0.0);
  }
}

model::Interval widened_range(const Samples& samples) {
  model::Interval range = samples.range;
  for (const std::span<const double> inputs : {samples.prehistory, samples.input})
    for (const double v : inputs) range = {std::min(range.lo, v), std::max(range.hi, v)};
  return range;
}

std::vector<History> histories(const Samples& samples, const model::Interval& range) {
  std::vector<History> all{{samples.input.front()}, {range.hi, range.lo}, {range.lo, range.hi}};
  if (!samples.prehistory.empty()) all.emplace_back(samples.prehistory.begin(), samples.prehistory.end());
  return all;
}

Eigen::VectorXd at(const std::vector<std::size_t>& places, std::span<const double> values) {
  Eigen::VectorXd some(static_cast<Eigen::Index>(places.size()));
  for (Eigen::Index i = 0; i < some.size(); ++i) some[i] = values[places[static_cast<std::size_t>(i)]];
  return some;
}

}  // namespace hystcan::identification
