#include "model/preisach.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "model/fingerprint.h"
#include "model/memory_model_impl.h"

namespace hystcan::model {
namespace {

std::size_t levels_of(std::size_t weights) {
  std::size_t levels = 0;
  while (levels * (levels + 1) / 2 < weights) ++levels;
  if (levels == 0 || levels * (levels + 1) / 2 != weights)
    refuse(weights,
           " weights, expected N (N + 1) / 2 weights for N parts of the input range: 1, 3, 6, 10, ...");
  return levels;
}

void check_not_negative(const std::string& what, double number) {
  if (!std::isfinite(number) || number < 0.0) refuse(what, " is ", number, ", expected a number >= 0");
}

void check(const PreisachParameters& p) {
  if (!(p.input_range.lo < p.input_range.hi) || !std::isfinite(p.input_range.span()))
    refuse("input range [", p.input_range.lo, ", ", p.input_range.hi, "], expected finite lo < hi");
  if (!std::isfinite(p.offset)) refuse("offset is ", p.offset, ", expected a finite number");
  check_not_negative("gain", p.gain);
  double sum = p.gain;
  for (std::size_t i = 0; i < p.weights.size(); ++i) {
    check_not_negative(text_of("weight ", i), p.weights[i]);
    sum += p.weights[i];
  }
  if (!(sum > 0.0) || !std::isfinite(sum))
    refuse("gain and weights add up to ", sum, ", expected an increasing output, that is a positive sum");
}

}  // namespace

EverettLaw::EverettLaw(PreisachParameters parameters)
    : parameters_(std::move(parameters)), levels_(levels_of(parameters_.weights.size())) {
  check(parameters_);
  below_.assign((levels_ + 1) * (levels_ + 1), 0.0);
  const double* weight = parameters_.weights.data();
  for (std::size_t i = 0; i < levels_; ++i) {
    double row = 0.0;
    for (std::size_t j = 0; j < levels_; ++j) {
      if (j <= i) row += *weight++;
      below_[(i + 1) * (levels_ + 1) + j + 1] = below(i, j + 1) + row;
    }
  }
}

std::uint64_t EverettLaw::fingerprint() const {
  Fingerprint sum;
  sum.add(kind(), parameters_.input_unit, parameters_.output_unit, input_range().lo, input_range().hi,
          parameters_.offset, parameters_.gain, parameters_.weights);
  return sum.value();
}

EverettLaw::Cell EverettLaw::cell(double input) const {
  const double levels = static_cast<double>(levels_);
  const double place = std::clamp((input - input_range().lo) / input_range().span() * levels, 0.0, levels);
  const auto index = std::min(static_cast<std::size_t>(place), levels_ - 1);
  return {index, place - static_cast<double>(index)};
}

double EverettLaw::weight_up_to(Cell v) const {
  const std::size_t i = v.index;
  return below(i, i) + v.fraction * (below(i + 1, i) - below(i, i)) +
         v.fraction * v.fraction * on_diagonal(i);
}

// Returns the total weight of the relays that switch up at an input alpha' <= alpha and down at an input
// beta' <= beta. The cells form a triangle (top of model/preisach.h): a row for each part of alpha', a column
// for each part of beta'. The input alpha divides its row at the fraction p of the height, and the input beta
// divides its column at the fraction q of the width. A cell off the diagonal is a square, so that its weight
// is linear in p and q. The cell on the diagonal of column j is a triangle: the part up to the fraction q of
// its width has the share q (2 - q) of its weight.
double EverettLaw::left_of(Cell alpha, Cell beta) const {
  const std::size_t i = alpha.index, j = beta.index;
  const double p = alpha.fraction, q = beta.fraction;
  if (i == j) return below(i, i) + p * (below(i + 1, i) - below(i, i)) + q * (2.0 * p - q) * on_diagonal(i);
  return (1.0 - p) * ((1.0 - q) * below(i, j) + q * below(i, j + 1)) +
         p * ((1.0 - q) * below(i + 1, j) + q * below(i + 1, j + 1)) + q * (1.0 - q) * on_diagonal(j);
}

double EverettLaw::everett(double alpha, double beta) const {
  const Cell a = cell(alpha);
  return weight_up_to(a) - left_of(a, cell(beta));
}

Branch EverettLaw::threshold_branch(Direction direction) const {
  const Interval& range = input_range();
  if (direction == Direction::ascending) return {range.lo, parameters_.offset, 0.0, 0.0, true};
  const double top = parameters_.offset + parameters_.gain * range.span() + below(levels_, levels_);
  return {range.hi, top, 0.0, 0.0, true};
}

Branch EverettLaw::reversed(const HysteresisState& state) const {
  return {state.input, state.level, 0.0, 0.0, true};
}

double EverettLaw::value(const Branch& branch, Direction direction, double input) const {
  const double s = branch.start_input;
  const double moved = parameters_.gain * (input - s);
  return branch.start_level +
         (direction == Direction::ascending ? moved + everett(input, s) : moved - everett(s, input));
}

// Returns the slope of a branch that starts at v_s (E: Everett function, model/preisach.h). For a rising
// branch, this is `gain` plus the derivative of E(v, v_s) by v. For a falling branch, it is `gain` plus the
// derivative of -E(v_s, v) by v.
double EverettLaw::slope(const Branch& branch, Direction direction, double input) const {
  const Cell v = cell(input), s = cell(branch.start_input);
  const std::size_t i = v.index, j = s.index;
  const double row = below(i + 1, i) - below(i, i);
  double change = 0.0;
  if (i == j)
    change = 2.0 * std::abs(v.fraction - s.fraction) * on_diagonal(i);
  else if (direction == Direction::ascending)
    change = row + 2.0 * v.fraction * on_diagonal(i) -
             ((1.0 - s.fraction) * (below(i + 1, j) - below(i, j)) +
              s.fraction * (below(i + 1, j + 1) - below(i, j + 1)));
  else
    change = (1.0 - s.fraction) * (below(j, i + 1) - below(j, i)) +
             s.fraction * (below(j + 1, i + 1) - below(j + 1, i)) + (1.0 - 2.0 * v.fraction) * on_diagonal(i);
  return parameters_.gain + change * static_cast<double>(levels_) / input_range().span();
}

Jet EverettLaw::jet(const Branch& branch, Direction direction, double input) const {
  return {value(branch, direction, input), slope(branch, direction, input), 0.0};
}

template class MemoryModel<EverettLaw>;

}  // namespace hystcan::model
