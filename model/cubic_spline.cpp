#include "model/cubic_spline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"

namespace hystcan::model {
namespace {

constexpr std::size_t most_knots = 64;
constexpr std::size_t degree = 3;

// Returns element `i` of the knots with the first and the last knot repeated, so that each of these two
// counts four times. Such a knot vector begins with three more copies of the first knot; therefore element i
// is knot i - 3 of `knots`. An index beyond the list gives the first or the last knot.
double clamped(std::span<const double> knots, std::size_t i) {
  return knots[std::clamp<std::size_t>(i, degree, degree + knots.size() - 1) - degree];
}

// Returns the B-splines of each degree up to 3 at v, on the interval that starts at knot `j` (Cox and de
// Boor's recurrence).
std::array<std::array<double, degree + 1>, degree + 1> recurrence(std::span<const double> knots,
                                                                  std::size_t j, double v) {
  std::array<std::array<double, degree + 1>, degree + 1> B{};
  B[0][0] = 1.0;
  for (std::size_t d = 1; d <= degree; ++d)
    for (std::size_t i = 0; i < d; ++i) {
      const double lo = clamped(knots, j + degree + 1 + i - d), hi = clamped(knots, j + degree + 1 + i);
      const double share = B[d - 1][i] / (hi - lo);
      B[d][i] += share * (hi - v);
      B[d][i + 1] += share * (v - lo);
    }
  return B;
}

BSplines on_interval(std::span<const double> knots, std::size_t j, double v) {
  const auto B = recurrence(knots, j, v);
  // Returns the derivatives of the B-splines of degree d. `lower`: values of the B-splines of degree d - 1.
  // Each derivative is d times a difference of two of these values, each divided by the width between the
  // first and the last knot of its B-spline.
  const auto differences = [&](const std::array<double, degree + 1>& lower, std::size_t d) {
    std::array<double, degree + 1> slopes{};
    for (std::size_t i = 0; i < d; ++i) {
      const double width = clamped(knots, j + degree + 1 + i) - clamped(knots, j + degree + 1 + i - d);
      slopes[i] -= static_cast<double>(d) * lower[i] / width;
      slopes[i + 1] += static_cast<double>(d) * lower[i] / width;
    }
    return slopes;
  };
  const auto slopes = differences(B[2], degree), curvatures = differences(differences(B[1], 2), degree);
  BSplines row{j, {}};
  for (std::size_t i = 0; i <= degree; ++i) row.at[i] = {B[degree][i], slopes[i], curvatures[i]};
  return row;
}

void check(const std::vector<double>& knots, const std::vector<double>& coefficients) {
  if (knots.size() < 2 || knots.size() > most_knots)
    refuse("spline has ", knots.size(), " knots, expected 2 to ", most_knots);
  for (std::size_t i = 1; i < knots.size(); ++i)
    if (!(knots[i - 1] < knots[i]) || !std::isfinite(knots[i] - knots[i - 1]))
      refuse("spline knot ", knots[i], " after ", knots[i - 1], ", expected finite increasing knots");
  if (coefficients.size() != knots.size() + 2)
    refuse("spline of ", knots.size(), " knots has ", coefficients.size(), " coefficients, expected ",
           knots.size() + 2);
}

}  // namespace

BSplines bsplines(std::span<const double> knots, double v) {
  const double inside = std::clamp(v, knots.front(), knots.back());
  const auto next = std::upper_bound(knots.begin(), knots.end() - 1, inside);
  const auto j = static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - knots.begin(), 1) - 1);
  BSplines row = on_interval(knots, std::min(j, knots.size() - 2), inside);
  if (v == inside) return row;
  for (Jet& jet : row.at) jet = {jet.value + jet.slope * (v - inside), jet.slope, 0.0};
  return row;
}

std::vector<double> greville_points(std::span<const double> knots) {
  std::vector<double> points;
  for (std::size_t i = 0; i < knots.size() + 2; ++i)
    points.push_back((clamped(knots, i + 1) + clamped(knots, i + 2) + clamped(knots, i + 3)) / 3.0);
  return points;
}

CubicSpline::CubicSpline(std::vector<double> knots, std::vector<double> coefficients)
    : knots_(std::move(knots)), coefficients_(std::move(coefficients)) {
  check(knots_, coefficients_);
  const auto at = [&](std::size_t interval, double v) {
    const BSplines row = on_interval(knots_, interval, v);
    Jet sum;
    for (std::size_t i = 0; i < row.at.size(); ++i) {
      const double c = coefficients_[row.first + i];
      sum.value += c * row.at[i].value;
      sum.slope += c * row.at[i].slope;
      sum.curvature += c * row.at[i].curvature;
    }
    return sum;
  };
  for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
    const double width = knots_[i + 1] - knots_[i];
    const Jet begin = at(i, knots_[i]), end = at(i, knots_[i + 1]);
    if (i == 0) pieces_.push_back({knots_[0], begin.value, begin.slope, 0.0, 0.0});
    pieces_.push_back({knots_[i], begin.value, begin.slope, 0.5 * begin.curvature,
                       (end.curvature - begin.curvature) / (6.0 * width)});
    if (i + 2 == knots_.size()) pieces_.push_back({knots_[i + 1], end.value, end.slope, 0.0, 0.0});
  }
  cells_per_input_ = static_cast<double>(cells) / (knots_.back() - knots_.front());
  std::size_t piece = 1;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    // The table `first_in_` divides the range of the knots into equal cells; piece() starts at the entry of a
    // cell. The cell begins a little earlier here, so that a rounding error in piece() cannot skip a piece.
    const double before = knots_.front() + (static_cast<double>(cell) - 1e-6) / cells_per_input_;
    while (piece + 2 < pieces_.size() && pieces_[piece + 1].start <= before) ++piece;
    first_in_[cell] = static_cast<std::uint8_t>(piece);
  }
}

}  // namespace hystcan::model
